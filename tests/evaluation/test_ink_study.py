"""Recall and precision of ink mean what they say, and the factor of a row was chosen on other patients."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.inked_scan import inked_zip, place, strokes

from breastrig.core.errors import BadInput
from breastrig.evaluation.cohort import Case, read_cohort
from breastrig.evaluation.studies.ink import FACTORS, SAMPLE, TrueLines, ink_study, true_lines
from breastrig.evaluation.studies.plan import Plan
from breastrig.evaluation.studies.result_cache import Record, Unit
from breastrig.evaluation.tables.ink import chosen_factor, console, ink_table
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path
from breastrig.scan.read import read_scan


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
