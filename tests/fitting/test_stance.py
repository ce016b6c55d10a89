"""Standing or lying, when the scan shows no table."""

from pathlib import Path

import numpy as np
import pytest

from breastrig.core.arrays import Array
from breastrig.core.assets import asset_folder
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.fit import FitTask
from breastrig.fitting.orientation import best_start
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.stance import FoundStance, found_stance
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.parameters import rest_parameters
from breastrig.scan.clean import clean, compact
from breastrig.scan.orient import Frame, propose_frame, table_plane
from breastrig.scan.read import read_scan

EXAMPLE = asset_folder("example")


def scan_without_table(place: Path) -> ScanTarget:
    surface = clean(read_scan(place / "scan.ply", None, "auto", texture=False))
    vertices, faces = surface.vertices - surface.vertices.mean(axis=0), surface.faces
    corners = vertices[faces]
    crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = 0.5 * np.linalg.norm(crosses, axis=1)
    table = table_plane(corners.mean(axis=1), crosses / np.maximum(2.0 * areas[:, None], 1e-12), areas)
    if table is not None:
        above = (vertices @ table[0] > table[1] + 0.025)[faces].all(axis=1)
        vertices, faces = compact(vertices, faces[above])
    return ScanTarget(vertices, faces)


def found(target: ScanTarget) -> tuple[FoundStance, Frame]:
    rig, frame = read_rig(default_rig_path()), propose_frame(target.vertices, target.faces)
    none: dict[str, Array] = {}
    task = FitTask(rig, target, best_start(rig, target, none, lambda: frame.fronts), load_recipe("default"), none)
    return found_stance(task, frame), frame


@pytest.mark.parametrize("stance", ["standing", "supine"])
def test_the_body_tells_when_there_is_no_table(stance: str) -> None:
    answer, frame = found(scan_without_table(EXAMPLE / stance))
    assert "no table" in frame.stance_reason
    assert answer.stance == stance
    assert "no table" in answer.reason


def test_a_table_needs_no_fit() -> None:
    surface = clean(read_scan(EXAMPLE / "supine" / "scan.ply", None, "auto", texture=False))
    target = ScanTarget(surface.vertices, surface.faces)
    frame = propose_frame(target.vertices, target.faces)
    assert frame.stance == "supine"
    rig = read_rig(default_rig_path())
    nothing = ScanTarget(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))  # a fit to it would fail
    task = FitTask(rig, nothing, rest_parameters(rig), load_recipe("default"), {})
    answer = found_stance(task, frame)
    assert (answer.stance, answer.reason, answer.iterates) == (frame.stance, frame.stance_reason, ())
