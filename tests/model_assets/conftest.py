"""The build steps stand outside of the package: `model_assets/` goes on the path for these tests."""

import sys
from pathlib import Path

import pytest

from breastrig.gltf.read_rig import read_rig
from breastrig.rig.model import Rig

MODEL_ASSETS = Path(__file__).resolve().parents[2] / "model_assets"
sys.path.insert(0, str(MODEL_ASSETS))


@pytest.fixture(scope="session")
def model_assets() -> Path:
    return MODEL_ASSETS


@pytest.fixture(scope="session")
def torso() -> Rig:
    return read_rig(MODEL_ASSETS / "built" / "torso.glb")
