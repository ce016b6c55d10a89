"""A cohort of one patient in two stances."""

from pathlib import Path

import pytest
from helpers.cohort import FEW, write_patient
from helpers.cohort import write_case as write_case  # other tests of this folder take it from here

from breastrig.rig.model import Rig


@pytest.fixture
def cohort(tmp_path: Path, rig: Rig) -> Path:
    write_patient(tmp_path / "cohort" / "patient_x", rig, 1, "makehuman", names=FEW)
    return tmp_path / "cohort"
