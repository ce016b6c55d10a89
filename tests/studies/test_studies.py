"""What the questions rest on: turned bodies, scaled compliances, rigs with fewer shapes, the table taken away."""

from dataclasses import replace
from pathlib import Path

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
from breastrig_studies.studies.orientation import without_table, wrong_way
from breastrig_studies.studies.reference_fit import reference_fit
from breastrig_studies.studies.sensitivity import TERMS, scaled_compliance
from breastrig_studies.studies.trust.certainty import across
from breastrig_studies.studies.trust.reliability import LEVELS, covered_at_levels

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


def test_radii_of_a_scatter_in_two_directions_hold_what_they_say(rng: np.random.Generator) -> None:
    errors = np.linalg.norm(rng.normal(size=(200_000, 2)), axis=1)
    *counts, total = covered_at_levels(errors, np.full(len(errors), np.sqrt(2.0 * np.log(10.0))))
    np.testing.assert_allclose(np.array(counts) / total, LEVELS, atol=0.005)
