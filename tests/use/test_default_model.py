"""What the fork server makes ready before any fit is what fits then find."""

import importlib
from pathlib import Path

from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.use import default_model
from breastrig.use.steps.prepare import read_model
from breastrig.use.steps.settings import FitJob


def test_the_model_of_a_job_is_there_already() -> None:
    importlib.reload(default_model)
    assert read_model(FitJob(Path("scan.ply"), Path("out"), {})) is read_rig(default_rig_path())
