"""The torso's landmarks, as the programs of model_assets know them."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "model_assets"))

from torso_rules import LANDMARKS

__all__ = ["LANDMARKS"]
