"""A cohort of one patient in two stances."""

from pathlib import Path

import pytest
from helpers.cohort import FEW, write_patient
from helpers.cohort import write_case as write_case  # other tests of this folder take it from here

from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig


@pytest.fixture(scope="session")
def rig() -> Rig:
    return read_rig(default_rig_path())


@pytest.fixture
def cohort(tmp_path: Path, rig: Rig) -> Path:
    write_patient(tmp_path / "cohort" / "patient_x", rig, 1, "makehuman", names=FEW)
    return tmp_path / "cohort"
