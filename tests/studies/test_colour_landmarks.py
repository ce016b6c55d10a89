"""Table A: landmarks proposed with colours and without, and the areolae's diameters."""

from typing import Any

import numpy as np
import pytest
from helpers.painted_body import painted_body

from breastrig.fitting.propose import Proposal
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig_studies.cohort import Case, read_cohort
from breastrig_studies.studies.colour_landmarks import colour_landmarks, exchanged
from breastrig_studies.virtual.case_files import write_json
from breastrig_studies.virtual.painted.files import write_painted_case
from breastrig_studies.virtual.scan import SimulatedScan

pytestmark = pytest.mark.long


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


def test_exchanged_sides_are_noticed() -> None:
    left, right = np.array([0.1, 0.0, 0.0]), np.array([-0.1, 0.0, 0.0])
    true = {"nipple_L": left, "nipple_R": right}
    right_way = {name: Proposal(at + 0.01, 0.5, True) for name, at in true.items()}
    wrong_way = {"nipple_L": Proposal(right, 0.5, True), "nipple_R": Proposal(left, 0.5, True)}
    assert not exchanged(right_way, true)
    assert exchanged(wrong_way, true)
    assert not exchanged(wrong_way, {"nipple_L": left})
