"""Wrong picks on the example patient: what a mistake explains is named and let go, what is strange is named."""

from pathlib import Path

import numpy as np
import pytest

from breastrig.core.assets import asset_folder
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.starts.orientation import sides_exchanged
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.scan.landmarks.landmark_files import read_landmarks
from breastrig.scan.read import read_scan
from breastrig.use.fit import run_fit
from breastrig.use.steps.events import Done
from breastrig.use.steps.settings import FitJob

pytestmark = pytest.mark.long

EXAMPLE = asset_folder("example") / "standing"


def picks() -> dict[str, list[float]]:
    places, unit = read_landmarks(EXAMPLE / "landmarks.json")
    assert unit == "mm"
    return {name: [float(value) for value in place] for name, place in places.items()}


def result(landmarks: dict[str, list[float]], out: Path) -> dict:
    *_, last = run_fit(FitJob(scan=EXAMPLE / "scan.ply", out=out, landmarks_mm=landmarks))
    assert isinstance(last, Done)
    return last.result.document()


def distances_to_true(found: dict) -> np.ndarray:
    per_mm = {"m": 1e3, "mm": 1.0}[found["scan"]["unit"]]
    return np.array([np.linalg.norm(per_mm * np.array(found["landmarks"][n]) - p) for n, p in picks().items()])


@pytest.mark.slow
@pytest.mark.parametrize("stance", ["standing", "supine"])
def test_few_right_picks_are_never_taken_for_exchanged_ones(stance: str, rng: np.random.Generator) -> None:
    rig, outliers = read_rig(default_rig_path()), load_recipe("default").outliers
    places, _ = read_landmarks(asset_folder("example") / stance / "landmarks.json")
    true = {name: 1e-3 * np.array(place) for name, place in places.items()}
    scan = read_scan(asset_folder("example") / stance / "scan.ply")
    mirrored = {landmark.name: landmark.mirror for landmark in rig.landmarks}
    target = ScanTarget(scan.vertices, scan.faces)
    for _ in range(30):
        names = rng.choice(sorted(true), rng.integers(3, 9), replace=False)
        clicked = {name: true[name] + rng.normal(0.0, 3e-3, 3) for name in names}
        assert not sides_exchanged(rig, clicked, target, outliers), sorted(clicked)
    assert sides_exchanged(rig, {mirrored[name]: place for name, place in true.items()}, target, outliers)


@pytest.mark.slow
def test_all_sides_exchanged_do_not_turn_the_patient_round(tmp_path: Path) -> None:
    swap = {"_L": "_R", "_R": "_L"}
    wrong = {name[:-2] + swap[name[-2:]] if name[-2:] in swap else name: place for name, place in picks().items()}
    found = result(wrong, tmp_path)
    assert "exchanged" in found["landmarks_not_followed"][0]["reason"]
    assert distances_to_true(found).mean() < 7.7  # as without picks
    assert found["surface_distance_mm"]["mean"] < 0.53


@pytest.mark.slow
def test_three_picks_nearly_on_a_line_do_not_turn_the_patient(tmp_path: Path) -> None:
    names, place = ("suprasternal_notch", "mid_sternum", "xiphoid"), EXAMPLE.parent / "supine"
    true = {n: [float(v) for v in p] for n, p in read_landmarks(place / "landmarks.json")[0].items()}
    rng = np.random.default_rng(3)
    three = {name: [value + 4.0 * rng.normal() for value in true[name]] for name in names}
    *_, last = run_fit(FitJob(scan=place / "scan.ply", out=tmp_path, landmarks_mm=three))
    assert isinstance(last, Done)
    per_mm = {"m": 1e3, "mm": 1.0}[last.result.document()["scan"]["unit"]]
    gaps = [np.linalg.norm(per_mm * np.array(last.result.document()["landmarks"][n]) - true[n]) for n in true]
    assert np.mean(gaps) < 20.0
