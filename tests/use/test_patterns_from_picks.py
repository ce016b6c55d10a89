"""Patterns begin where the surgeon has picked, as measures do, and not where the model's shapes can follow."""

import json
from pathlib import Path

import numpy as np
import pytest

from breastrig.core.assets import asset_folder
from breastrig.drawings.handles.live_pattern import LiveSkin
from breastrig.drawings.plan_on_scan import PlannedScan, plan_on_scan
from breastrig.drawings.plan_schema import PlanPattern
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.scan.landmarks.landmark_files import read_landmarks
from breastrig.use.fit import run_fit
from breastrig.use.folder.fit_folder import fit_folder_of
from breastrig.use.steps.events import Done
from breastrig.use.steps.settings import FitJob

EXAMPLE = asset_folder("example") / "standing"
BESIDE = np.array([6.0, 5.0, 0.0])  # mm from the example's own pick, along the front; the model follows half of the way


def fitted_with(nipple: np.ndarray, out: Path) -> dict[str, object]:
    """The result of a fit whose left nipple was picked so far from the example's pick."""
    places, _ = read_landmarks(EXAMPLE / "landmarks.json")
    picks = {name: [float(value) for value in place] for name, place in places.items()}
    picks["nipple_L"] = [float(value) for value in np.array(picks["nipple_L"]) + nipple]
    asked = FitJob(scan=EXAMPLE / "scan.ply", out=out, landmarks_mm=picks, drawing="periareolar")
    *_, last = run_fit(asked)
    assert isinstance(last, Done)
    return last.result.document()


def areola(out: Path) -> np.ndarray:
    """(M, 3) in the scan's unit: the circle around the left nipple"""
    shapes = json.loads((out / "drawing.json").read_text("utf-8"))["shapes"]
    (found,) = (shape["points"] for shape in shapes if shape["name"] == "areola_L")
    return np.array(found)


def off_centre(circle: np.ndarray, place: np.ndarray) -> float:
    """How much farther a place is from one side of a circle than from the other, at most; in m."""
    far = np.linalg.norm(circle - place, axis=1)
    return float(0.5 * np.abs(far - np.roll(far, len(far) // 2)).max())


@pytest.fixture(scope="module")
def beside(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("beside")
    result = fitted_with(BESIDE, out)
    assert result["landmarks_not_followed"] == []
    return out


def test_of_a_fit_of_a_plan_and_under_a_hand_alike(beside: Path) -> None:
    rig = read_rig(default_rig_path())
    found = fit_folder_of(beside, rig)
    pick, model = found.landmarks["nipple_L"], np.array(found.result.landmarks["nipple_L"])  # this scan is in metres
    assert np.linalg.norm(pick - model) > 0.002  # the model does not follow all of the way
    circle = areola(beside)
    assert off_centre(circle, pick) < 0.0008
    assert off_centre(circle, model) > 0.001
    scan = found.fitted_scan
    pattern = PlanPattern(id="lift", scan="standing", name="periareolar")
    planned = plan_on_scan(rig, PlannedScan("standing", scan, (pattern,)), ())
    live = LiveSkin(rig, scan).drawn("periareolar", {})
    for lines in ([each.line for each in planned.lines], [line for line, _ in live.lines]):
        (again,) = (line.points for line in lines if line.name.startswith("areola_L"))
        assert again == pytest.approx(circle, abs=2e-6)
