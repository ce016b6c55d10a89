"""Recall and precision of ink mean what they say, and the factor of a row was chosen on other patients."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from helpers.inked_scan import inked_zip, place, strokes

from breastrig.core.errors import BadInput
from breastrig.fitting.recipe import load_recipe
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.gltf.read_rig import default_rig_path
from breastrig.scan.read import read_scan
from breastrig_studies.cohort import Case, read_cohort
from breastrig_studies.studies import ink as study
from breastrig_studies.studies.ink import FACTORS, SAMPLE, TrueLines, ink_study, ink_transfer_study, true_lines
from breastrig_studies.studies.plan import Plan
from breastrig_studies.studies.result_cache import Record, Unit
from breastrig_studies.tables.ink import chosen_factor, console, ink_table


@pytest.fixture(scope="module")
def cohort(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One coloured case whose true surface is the scan."""
    folder = tmp_path_factory.mktemp("cohort")
    case = folder / "one" / "standing"
    case.mkdir(parents=True)
    (case / "scan.zip").write_bytes(inked_zip())
    scan = read_scan(inked_zip(), units="m", texture=False)
    import trimesh

    trimesh.Trimesh(scan.vertices, scan.faces, process=False).export(case / "truth.ply")
    (case / "case.json").write_text(json.dumps({"unit": "m", "stance": "standing"}))
    (case / "landmarks.json").write_text(json.dumps({"unit": "m", "landmarks": {"nipple_L": [0, 0, 0]}}))
    shapes = [
        {
            "name": "text_1" if each.kind == "writing" else each.name,
            "closed": each.closed,
            "points": place(each.places).round(6).tolist(),
            "inked": each.drawn.tolist(),
        }
        for each in strokes()
    ]
    (case / "ink.json").write_text(json.dumps({"schema": "breastrig/drawing@1", "unit": "m", "shapes": shapes}))
    return folder


def test_a_coloured_case_is_asked_about_its_colours_only(cohort: Path) -> None:
    (case,) = read_cohort(cohort)
    assert (case.coloured, case.scan.name) == (True, "scan.zip")
    plan = Plan((case,), (load_recipe("default"),), default_rig_path(), 2, False)
    assert "ink" in {unit.question for unit in plan.first_round()}
    assert not {unit.question for unit in plan.first_round()} & {"accuracy", "halves", "clicks", "unseen", "measures"}
    assert plan.plain == ()


def test_true_lines_leave_out_letters_gaps_and_what_the_scan_does_not_show(cohort: Path, tmp_path: Path) -> None:
    (case,) = read_cohort(cohort)
    lines = true_lines(case, None)
    drawn = sum(0.5 * each.drawn.sum() for each in strokes() if each.kind != "writing")
    assert 1e3 * SAMPLE * lines.wanted.sum() == pytest.approx(drawn, rel=0.04)
    assert len(lines.places) > lines.wanted.sum()
    document = json.loads((case.folder / "ink.json").read_text())
    for shape in document["shapes"]:
        shape["seen"] = [False] * len(shape["points"])
    (tmp_path / "ink.json").write_text(json.dumps(document))
    assert not true_lines(replace(case, folder=tmp_path), None).wanted.any()
    (tmp_path / "ink.json").write_text("{}")
    with pytest.raises(BadInput, match="cannot be read as a drawing"):
        true_lines(replace(case, folder=tmp_path), None)


def test_what_is_found_is_measured_against_the_truth(cohort: Path) -> None:
    (case,) = read_cohort(cohort)
    answer = ink_study((case,), None, None)
    assert set(answer) == {f"{factor:g}" for factor in FACTORS}
    usual = answer["1"]
    assert usual["recall"] > 0.95
    assert usual["precision"] == 1.0
    assert usual["false_mm"] == 0.0
    assert usual["off_mm"] < 0.5
    lines = true_lines(case, None)
    assert isinstance(lines, TrueLines)
    assert usual["true_mm"] == pytest.approx(0.5 * lines.wanted.sum(), abs=0.1)


def _record(patient: str, stance: str, good: float, true_mm: float, false_mm: float = 0.0) -> Record:
    """A scan on which the factor `good` finds all, and the others half."""
    case = Case(patient, stance, stance, "makehuman", "m", Path(patient))
    answer = {
        f"{factor:g}": {
            "recall": None if true_mm == 0 else 1.0 if factor == good else 0.5,
            "precision": None if true_mm == 0 else 1.0,
            "off_mm": 0.3,
            "false_mm": false_mm if factor == good else 0.0,
            "true_mm": true_mm,
            "lines": 3,
            "time_s": 1.0,
        }
        for factor in FACTORS
    }
    return Record(Unit((case,), "ink", load_recipe("default"), Path("model.glb")), answer, None)


def test_the_factor_of_a_row_is_best_for_the_other_patients() -> None:
    records = [_record("a", "standing", 0.7, 900.0), _record("b", "standing", 1.2, 900.0), _record("c", "x", 1.2, 0.0)]
    table = ink_table(records)
    names = [column.name for column in table.columns]
    rows = {row.cells[0]: dict(zip(names, row.cells, strict=True)) for row in table.rows}
    assert rows["a"]["factor"] == 1.2  # of b
    assert rows["a"]["recall"] == 0.5
    assert rows["b"]["factor"] == 0.7  # of a
    assert rows["mean"]["recall"] == 0.5
    assert chosen_factor([]) == 1.0
    assert "0.50" in console(records)


def test_a_factor_that_draws_on_bare_skin_is_no_choice() -> None:
    records = [_record("a", "standing", 1.2, 900.0), _record("b", "supine", 1.2, 0.0, false_mm=80.0)]
    assert chosen_factor(records) == 1.0
    assert chosen_factor(records[:1]) == 1.2
    assert np.isclose(FACTORS, 1.0).any()


MOVED, WRONG_BY = np.array([0.0, 0.1, 0.0]), np.array([0.0, 0.0, 0.002])  # m: to the other stance, and how wrongly


def _scene(case: Case) -> Any:
    """What of a scene is needed here, without making it ready for a fit."""
    scan = read_scan(case.folder.parent / "standing" / "scan.zip", units="m", texture=False)
    search = ClosestPointSearch(scan.vertices, np.asarray(scan.faces))
    target = SimpleNamespace(search=search, vertices=scan.vertices, faces=np.asarray(scan.faces))
    at = np.array([[0.05, 0.1, 0.14], [-0.05, 0.1, 0.14], [0.0, 0.22, 0.14], [0.0, 0.0, 0.15]])
    names = ("nipple_L", "nipple_R", "suprasternal_notch", "umbilicus")
    return SimpleNamespace(case=case, target=target, truth=search, landmarks=dict(zip(names, at, strict=True)))


@pytest.fixture
def pair(cohort: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Case, Case]:
    """The inked scan, and the same skin lying: MOVED, but letters, which do not count, are far away."""
    (standing,) = read_cohort(cohort)
    document = json.loads((standing.folder / "ink.json").read_text())
    for shape in document["shapes"]:
        far = np.array([9.0, 9.0, 9.0]) if shape["name"].startswith("text") else MOVED
        shape["points"] = (np.array(shape["points"]) + far).tolist()
    (standing.folder / "ink_in_supine.json").write_text(json.dumps(document))
    lying = replace(standing, name="supine", stance="supine", folder=standing.folder.parent / "supine")
    monkeypatch.setattr(study, "read_scene", _scene)
    monkeypatch.setattr(study, "fitted", lambda _rig, _recipe, scene, _picks: scene.case.name)
    return standing, lying


def _carried_wrongly_by(off: np.ndarray, monkeypatch: pytest.MonkeyPatch) -> None:
    def carried(_rig: None, a: str, b: str, points: np.ndarray) -> tuple[np.ndarray, None]:
        assert (a, b) == ("standing", "supine")
        return points + MOVED + off, None

    monkeypatch.setattr(study, "points_carried", carried)


def test_found_ink_is_carried_as_the_true_lines_are_and_compared_at_the_same_places(
    pair: tuple[Case, Case], monkeypatch: pytest.MonkeyPatch
) -> None:
    _carried_wrongly_by(np.zeros(3), monkeypatch)
    (exact,) = ink_transfer_study(pair, None, None)["rows"]
    assert (exact["from"], exact["to"]) == ("standing", "supine")
    assert exact["true_mm"] < 0.1  # the scan's triangles are chords of the true skin
    assert 0.05 < exact["found_mm"] < 0.5  # how far found ink is from the middle of the pen's line
    wanted = true_lines(pair[0], None).wanted.sum()
    assert 0.95 * wanted < exact["points"] < 1.05 * wanted
    _carried_wrongly_by(WRONG_BY, monkeypatch)
    (wrong,) = ink_transfer_study(pair, None, None)["rows"]
    assert wrong["points"] == exact["points"]
    assert wrong["true_mm"] == pytest.approx(2.0, abs=0.1)
    assert wrong["true_mm"] - 0.1 < wrong["found_mm"] < 2.5


def test_a_pair_whose_ink_is_not_known_on_the_other_scan_is_not_asked(pair: tuple[Case, Case]) -> None:
    (pair[0].folder / "ink_in_supine.json").unlink()
    assert ink_transfer_study(pair, None, None) == {"rows": []}
    assert ink_transfer_study(pair[:1], None, None) == {"rows": []}
