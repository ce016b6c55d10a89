"""The documented example of another rig, model_assets/forearm.py, for tests."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "model_assets"))

from forearm import bent, forearm_rig, posed_forearm, write_bodies, write_forearm, write_scan

__all__ = ["bent", "forearm_rig", "posed_forearm", "write_bodies", "write_forearm", "write_scan"]
