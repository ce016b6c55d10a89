"""A proposal's error is that of the fit behind it: it holds the true place, on half a torso too."""

from dataclasses import replace

import numpy as np
import pytest

from breastrig.core.assets import asset_folder
from breastrig.fitting.propose import Proposal, confidence_of, expected_error
from breastrig.fitting.uncertainty.radii import HOLDS_90
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.scan.clean import compact
from breastrig.scan.landmark_files import read_landmarks
from breastrig.scan.read import read_scan
from breastrig.workflow.propose_on_scan import propose_on_scan

STANDING = asset_folder("example") / "standing"


def gaps_in_errors(proposals: dict[str, Proposal]) -> np.ndarray:
    """(L,) distance of each proposal from the true place, in units of its error."""
    true, unit = read_landmarks(STANDING / "landmarks.json")
    per_unit = {"mm": 1e-3, "m": 1.0}[str(unit)]
    errors = [each.error for each in proposals.values()]
    assert all(error is not None for error in errors)
    gaps = [np.linalg.norm(each.point - per_unit * true[name]) for name, each in proposals.items()]
    return np.array(gaps) / np.array(errors, dtype=np.float64)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_on_half_a_torso_the_errors_say_that_the_body_may_lie_another_way(side: float) -> None:
    scan = read_scan(STANDING / "scan.ply", "ply", "auto", texture=False)
    true, unit = read_landmarks(STANDING / "landmarks.json")
    per_unit = {"mm": 1e-3, "m": 1.0}[str(unit)] / scan.metres_per_unit
    left = per_unit * (true["acromion_L"] - true["acromion_R"])
    middle = per_unit * 0.5 * (true["acromion_L"] + true["acromion_R"])
    kept = (side * ((scan.vertices - middle) @ left) > 0.0)[scan.faces].all(axis=1)
    vertices, faces = compact(scan.vertices, scan.faces[kept])
    half = replace(scan, vertices=vertices, faces=faces)
    proposals = propose_on_scan(read_rig(default_rig_path()), half)
    assert (gaps_in_errors(proposals) <= 1.0).mean() >= 0.8


def test_a_confidence_is_that_of_its_error() -> None:
    proposals = propose_on_scan(
        read_rig(default_rig_path()), read_scan(STANDING / "scan.ply", "ply", "auto", texture=False)
    )
    for each in proposals.values():
        assert each.error is not None
        assert each.confidence == round(confidence_of(each.error / HOLDS_90), 2)
        assert 0.01 < each.error < 0.08
    for error in (0.005, 0.01, 0.04):
        assert expected_error(confidence_of(error)) == pytest.approx(error)
