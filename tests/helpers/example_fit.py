"""The example patient's fit as a task, ready to run: everything read, cleaned and indexed."""

from pathlib import Path

import numpy as np

from breastrig.core.assets import asset_folder
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.fit import FitTask
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.starts.orientation import start_from_landmarks
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.scan.clean import clean
from breastrig.scan.landmarks.landmark_files import read_landmarks
from breastrig.scan.read import read_scan

EXAMPLE = asset_folder("example") / "standing"


def indexed_scan(scan: Path) -> tuple[ScanTarget, np.ndarray]:
    """A scan file read, cleaned, centred at its mean and indexed, and the (3,) mean (m)."""
    surface = clean(read_scan(scan))
    centre = surface.vertices.mean(axis=0)
    target = ScanTarget(surface.vertices - centre, surface.faces)
    _ = target.rays, target.search, target.normals, target.on_border, target.face_normals, target.vertex_tree
    return target, centre


def example_task(scan: Path = EXAMPLE / "scan.ply", preset: str = "default", stance: str = EXAMPLE.name) -> FitTask:
    """The fit of the model to a scan of the example patient, with her landmarks in that stance."""
    rig = read_rig(default_rig_path())
    target, centre = indexed_scan(scan)
    places, unit = read_landmarks(EXAMPLE.with_name(stance) / "landmarks.json")
    assert unit == "mm"
    landmarks = {name: 1e-3 * np.asarray(place) - centre for name, place in places.items()}
    return FitTask(
        rig,
        target,
        start_from_landmarks(rig, landmarks),
        load_recipe(preset),
        {},
        stance=stance,
    ).with_picks(landmarks)
