"""Table A: landmarks proposed with colours and without, and the areolae's diameters."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.painted_body import painted_body

from breastrig.fitting.propose import Proposal
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig_studies.cohort import Case, read_cohort
from breastrig_studies.studies.colour_landmarks import colour_landmarks, exchanged, true_diameter
from breastrig_studies.studies.result_cache import Record, Unit
from breastrig_studies.tables.colour_landmarks import areolae_table, colour_landmarks_table, console
from breastrig_studies.virtual.case_files import write_json
from breastrig_studies.virtual.painted.files import write_painted_case
from breastrig_studies.virtual.scan import SimulatedScan

pytestmark = pytest.mark.long


def record(case: Case, answer: dict[str, Any]) -> Record:
    return Record(Unit((case,), "colour_landmarks", load_recipe("default"), Path("rig.glb")), answer, None)


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Case:
    """A painted woman with one covered nipple as a case of a cohort."""
    folder = tmp_path_factory.mktemp("cohort")
    woman = painted_body(tone=4, states=(("R", "covered"),), side=640)
    scan = SimulatedScan(woman.scan.vertices, woman.scan.faces, 0.0)
    write_painted_case(
        folder / "patient_4" / "standing",
        woman.body,
        woman.bodies.faces,
        scan,
        woman.picture.atlas,
        woman.picture.picture,
        woman.painted.marks,
        False,
        "mm",
        np.random.default_rng(4),
        {},
    )
    write_json(folder / "patient_4" / "patient.json", {"family": "makehuman"})
    (found,) = read_cohort(folder)
    return found


@pytest.fixture(scope="module")
def answer(case: Case) -> dict[str, Any]:
    return colour_landmarks((case,), read_rig(default_rig_path()), load_recipe("default"))


def test_the_seen_nipple_is_nearer_and_the_covered_one_stays_with_the_form(answer: dict[str, Any]) -> None:
    assert set(answer["seen"]) == {"nipple_L", "umbilicus"}
    assert answer["coloured"]["nipple_L"] < 6.0
    assert answer["held"]["nipple_L"] is True
    assert answer["states"] == {"nipple_L": "natural", "nipple_R": "covered"}
    assert answer["exchanged"] is False
    assert set(answer["areolae"]) == {"L"}  # the covered one has no true border
    assert answer["areolae"]["L"]["found_mm"] == pytest.approx(answer["areolae"]["L"]["true_mm"], abs=4.0)


def test_tables_give_means_shares_and_bias(case: Case, answer: dict[str, Any]) -> None:
    second = json.loads(json.dumps(answer))
    second["coloured"]["nipple_L"] = answer["coloured"]["nipple_L"] + 2.0
    second["exchanged"] = True
    second["areolae"]["L"]["found_mm"] = None
    records = [record(case, answer), record(case, second)]
    table = colour_landmarks_table(records)
    names = [column.name for column in table.columns]
    rows = {row.cells[0]: dict(zip(names, row.cells, strict=True)) for row in table.rows}
    assert rows["nipple"]["number"] == 4
    assert rows["nipple"]["exchanged"] == 1
    assert rows["nipple"]["seen"] == 0.5
    natural = rows["nipple, natural"]["coloured_mm"]
    assert natural == pytest.approx(answer["coloured"]["nipple_L"] + 1.0)
    assert rows["all"]["number"] == 2 * len(answer["coloured"])
    areolae = areolae_table(records)
    (standing, everything) = areolae.rows
    assert standing.cells[1:] == everything.cells[1:]
    assert standing.cells[1:3] == (2, 0.5)
    error = answer["areolae"]["L"]["found_mm"] - answer["areolae"]["L"]["true_mm"]
    assert standing.cells[3] == pytest.approx(error)
    assert "nipple, covered" in console(records)
    assert console([]) == ""


def test_exchanged_sides_are_noticed() -> None:
    left, right = np.array([0.1, 0.0, 0.0]), np.array([-0.1, 0.0, 0.0])
    true = {"nipple_L": left, "nipple_R": right}
    right_way = {name: Proposal(at + 0.01, 0.5, True) for name, at in true.items()}
    wrong_way = {"nipple_L": Proposal(right, 0.5, True), "nipple_R": Proposal(left, 0.5, True)}
    assert not exchanged(right_way, true)
    assert exchanged(wrong_way, true)
    assert not exchanged(wrong_way, {"nipple_L": left})


def test_a_circles_diameter_is_that_of_its_border() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)
    rim = 0.02 * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    assert true_diameter(rim) == pytest.approx(0.04, rel=1e-3)
