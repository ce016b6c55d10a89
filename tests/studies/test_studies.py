"""What the questions rest on: turned bodies, scaled compliances, rigs with fewer shapes, the table taken away."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.recipe import load_recipe
from breastrig.geometry.rotations import exp_so3
from breastrig.rig.model import Rig
from breastrig_studies.cohort import read_cohort
from breastrig_studies.studies import case as case_module
from breastrig_studies.studies.case import read_scene
from breastrig_studies.studies.measures import measures_study
from breastrig_studies.studies.orientation import without_table, wrong_way
from breastrig_studies.studies.reference_fit import reference_fit
from breastrig_studies.studies.sensitivity import TERMS, scaled_compliance
from breastrig_studies.studies.trust.certainty import across, certainty
from breastrig_studies.studies.trust.reliability import LEVELS, covered_at_levels
from breastrig_studies.studies.trust.verdicts import verdicts
from breastrig_studies.studies.unseen import CUTS, cut_fit, unseen, whole_fit
from breastrig_studies.tables.measures import measures_table, ptosis_table
from breastrig_studies.tables.verdicts import verdicts_table

pytestmark = pytest.mark.long


@pytest.mark.parametrize(
    ("turn", "wrong"),
    [
        ((0.0, 0.0, 0.0), set()),
        ((0.3, 0.3, 0.3), set()),  # 30 degrees
        ((0.0, 0.0, np.pi), {"up", "sides"}),  # upside down, still facing
        ((0.0, np.pi, 0.0), {"facing", "sides"}),  # front to back
        ((np.pi, 0.0, 0.0), {"up", "facing"}),  # upside down and front to back: sides stay
        ((0.0, 0.0, 1.0), {"up"}),  # 57 degrees
    ],
)
def test_the_wrong_way_is_named_by_axis(rig: Rig, turn: tuple[float, float, float], wrong: set[str]) -> None:
    places = rig.landmark_points().positions(rig.template, rig.faces)
    true = dict(zip(rig.landmark_names, 1.1 * places + 0.3, strict=True))
    found = wrong_way(rig, rig.template @ exp_so3(np.array(turn)).T, true)
    assert {axis for axis, is_wrong in found.items() if is_wrong} == wrong


def test_a_scan_is_searched_once_for_all_fits_to_it(cohort: Path, rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, search, searches = read_scene(read_cohort(cohort)[0]), case_module.start_from_scan, []
    monkeypatch.setattr(case_module, "start_from_scan", lambda *asked: searches.append(asked) or search(*asked))
    few = {name: scene.landmarks[name] for name in ("suprasternal_notch", "xiphoid", "umbilicus")}
    with_few, alone = scene.start(rig, few), scene.start(rig, {})
    scene.start(rig, scene.landmarks)
    assert len(searches) == 1
    np.testing.assert_array_equal(alone.rotations, scene.place(rig).parameters.rotations)
    np.testing.assert_array_equal(with_few.rotations, alone.rotations)  # nothing but the scan says where her front is


def test_without_the_table_only_the_body_is_left(cohort: Path, rig: Rig) -> None:
    place = cohort / "patient_x" / "supine"
    body = trimesh.load(place / "scan.ply", process=False)
    table = trimesh.creation.box((2.0, 2.0, 0.01)).subdivide_loop(4)
    table.apply_translation((0.0, 0.0, body.vertices[:, 2].min() - 0.1))
    both = trimesh.util.concatenate([body, table])
    both.export(place / "scan.ply")
    scene = read_scene(next(case for case in read_cohort(cohort) if case.name == "supine"))
    assert len(scene.target.faces) == pytest.approx(len(body.faces), rel=0.01)  # cleaning may drop a few
    with_table = replace(scene, target=ScanTarget(np.asarray(both.vertices), np.asarray(both.faces)))
    assert len(with_table.target.faces) > len(body.faces) + 1000
    assert len(without_table(with_table).target.faces) == pytest.approx(len(body.faces), rel=0.01)


def test_a_cut_leaves_what_lies_above_it_and_its_fit_is_compared_with_the_whole(cohort: Path, rig: Rig) -> None:
    scene, recipe = read_scene(read_cohort(cohort)[0]), load_recipe("default")
    whole = whole_fit(scene, rig, recipe)
    numbers = unseen(scene, rig, recipe)
    assert set(numbers) == set(CUTS)
    for cut, of in numbers.items():
        part = cut_fit(scene, rig, recipe, whole, cut)
        assert of["kept"] == len(part.scene.target.faces) / len(scene.target.faces)
        assert of["most_moved_mm"] >= of["moved_mm"] > 0.0
        assert of["smallest_scale"] <= 1.0 <= of["largest_scale"]
        gap = 1e3 * np.linalg.norm(part.fit.vertices - whole.vertices, axis=1)
        assert of["moved_mm"] == pytest.approx(gap.mean())
    assert numbers["half"]["kept"] == pytest.approx(0.5, abs=0.05)
    assert numbers["nipples"]["kept"] < numbers["navel"]["kept"] < 1.0
    half = cut_fit(scene, rig, recipe, whole, "half")
    assert {"xiphoid", "nipple_L"} <= set(half.scene.landmarks)
    assert "nipple_R" not in half.scene.landmarks


@pytest.mark.parametrize("term", TERMS)
@pytest.mark.parametrize("preset", ["default", "paper"])
def test_a_compliance_is_the_square_of_its_sigmas_and_of_no_others(preset: str, term: str) -> None:
    recipe = load_recipe(preset)
    assert scaled_compliance(recipe, term, 1.0) == recipe
    before, after = recipe.model_dump(), scaled_compliance(recipe, term, 100.0).model_dump()
    changed = set()

    def compare(path: str, a: object, b: object) -> None:
        if isinstance(a, dict):
            assert isinstance(b, dict)
            for key in a:
                compare(key if path == "" else f"{path}.{key}", a[key], b[key])
        elif isinstance(a, list | tuple) and a and isinstance(a[0], dict):
            assert isinstance(b, list | tuple)
            for each_a, each_b in zip(a, b, strict=True):
                compare(path, each_a, each_b)
        elif a != b:
            assert np.allclose(b, (100.0 if path == "body.share" else 10.0) * np.asarray(a))  # a share of variances
            changed.add(path)

    compare("", before, after)
    allowed = {
        "data": {"observed.skin"},
        "landmarks": {"observed.landmark"},
        "scales": {"scales.sigma", "scales.neighbour_sigma", "body.share", "body.scale_sigma"},
        "shapes": {"shapes.sigma", "shapes.factor", "body.share"},
        "joints": {
            *("joints.rotation_sigma", "joints.translation_sigma"),
            *("joints.rotation_factor", "joints.translation_factor"),
        },
    }
    assert changed
    assert changed <= allowed[term]


def test_the_reference_lies_on_the_whole_true_skin(cohort: Path, rig: Rig) -> None:
    scene = read_scene(read_cohort(cohort)[0])
    found = reference_fit(scene, rig, load_recipe("default"))
    assert np.median(scene.truth.query(found.vertices).distances) < 0.0005
    assert reference_fit(replace(scene, truth=None), rig, load_recipe("default")) is None


def test_a_line_is_as_far_off_as_its_places_are_across_it() -> None:
    """What lies along the line does not count: two thirds of the length on the mean, nine of ten within 0.988 of it."""
    flat, outwards = np.tile([0.01, 0.0, 0.0], (20_000, 1)), np.tile([0.0, 0.0, 1.0], (20_000, 1))
    off = across(flat, outwards)
    assert off.mean() == pytest.approx(0.01 * 2.0 / np.pi, rel=0.01)
    assert np.percentile(off, 90) == pytest.approx(0.01 * np.sin(0.45 * np.pi), rel=0.01)
    assert across(0.01 * outwards, outwards).max() < 1e-12


def test_certainty_counts_every_landmark_and_every_vertex_of_the_regions(cohort: Path, rig: Rig) -> None:
    scene = read_scene(read_cohort(cohort)[0])
    answer = certainty(scene, rig, load_recipe("default"))
    assert set(answer) == {"exact", "clicked", "half"}
    marks = sum(total for _, total in answer["exact"]["landmarks"].values())
    assert marks == len(scene.landmarks)
    skin = sum(total for _, total in answer["exact"]["skin"].values())
    assert skin == sum(map(len, rig.regions.values()))
    assert answer["exact"]["lines"].keys() == {"breasts, across the line"}
    for trial in answer.values():
        for *held_by_level, total in trial["levels"].values():
            assert held_by_level == sorted(held_by_level)
            assert held_by_level[-1] <= total
        of_90 = sum(counts[2] for group, counts in trial["levels"].items() if group.startswith("landmarks"))
        assert of_90 == sum(good for good, _ in trial["landmarks"].values())
        assert trial["dropped"] == 0, "right picks are believed"
        for part in ("landmarks", "skin"):
            assert all(0 <= good <= total for good, total in trial[part].values())


def test_radii_of_a_scatter_in_two_directions_hold_what_they_say(rng: np.random.Generator) -> None:
    errors = np.linalg.norm(rng.normal(size=(200_000, 2)), axis=1)
    *counts, total = covered_at_levels(errors, np.full(len(errors), np.sqrt(2.0 * np.log(10.0))))
    np.testing.assert_allclose(np.array(counts) / total, LEVELS, atol=0.005)


def record(question: str, answer: dict[str, object]) -> SimpleNamespace:
    unit = SimpleNamespace(question=question, recipe=SimpleNamespace(name="default"))
    return SimpleNamespace(unit=unit, failed=None, answer=answer)


def test_measures_are_compared_with_those_of_the_true_surface(cohort: Path, rig: Rig) -> None:
    scene = read_scene(read_cohort(cohort)[0])
    answer = measures_study(scene, rig, load_recipe("default"))
    straight = {row[0]: row for row in answer["exact"] if row[1] == "straight"}
    _, _, unit, true, found, low, high = straight["notch_nipple"]
    assert unit == "mm"
    assert found == pytest.approx(true, abs=1e-6)  # between true picks
    assert low < true < high
    (apart,) = (row for row in answer["none"] if row[:2] == ["notch_nipple", "straight, left - right"])
    assert apart[5] < apart[3] < apart[6]
    grades = {row[0] for row in answer["exact"]} - {row[0] for row in answer["none"]}
    assert grades == {"nipple_above_fold", "lowest_point_above_fold", "ptosis"}  # of a nipple that somebody knows
    table = measures_table([record("measures", answer)])
    names = [column.name for column in table.columns]
    assert "ptosis" not in {row.cells[0] for row in table.rows}
    for row in table.rows:
        cells = dict(zip(names, row.cells, strict=True))
        assert (cells["none_error"] is None) == (cells["measure"] in grades)
        assert cells["exact_held"] in (0.0, 50.0, 100.0)
    (row,) = (row for row in ptosis_table([record("measures", answer)]).rows if row.cells[0] == "exact picks")
    assert row.cells[1:4] == ("none", 2, 100.0)


def test_a_right_fit_is_distinguished_from_one_that_is_head_down(cohort: Path, rig: Rig) -> None:
    answer = verdicts(read_scene(read_cohort(cohort)[0]), rig, load_recipe("default"))
    assert answer["whole"]
    fits = answer["fits"]
    assert fits["landmarks"]["error_mm"] < 5.0
    assert fits["head_down"]["error_mm"] > 150.0
    assert fits["head_down"]["level"] != "good"
    assert fits["head_down"]["reasons"]
    table = verdicts_table([record("verdicts", answer)])
    rows = {row.cells[0]: row.cells[1:] for row in table.rows}
    assert rows["head down"][:3] == ("whole", "wrong", 1)
    assert rows["landmarks given"][:3] == ("whole", "right", 1)
    for row in rows.values():
        assert sum(share for share in row[3:] if isinstance(share, float)) == pytest.approx(100.0)
