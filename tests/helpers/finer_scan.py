"""The example patient scanned anew at a finer resolution: benchmarks need scans of 50,000 and 80,000 triangles.

The example's own scan serves as the body, the package's simulated depth camera walks around it, and the fusion's
voxel sets the number of triangles.  Seeded, so every run measures the same scan.
"""

from pathlib import Path

import numpy as np
import trimesh

from breastrig.scan.clean import clean
from breastrig.scan.read import read_scan
from breastrig_studies.virtual.depth_camera import DepthCamera, look_at, take
from breastrig_studies.virtual.depth_fusion import fuse, without_small_pieces

UP = np.array([0.0, 1.0, 0.0])  # case.json of the standing example
HEIGHTS = (-0.25, -0.05, 0.15, 0.35, 0.55)  # m, of the camera over the middle of the scan
AZIMUTHS = np.radians(np.linspace(-110, 110, 13))  # around the front: behind it the inside of the scan would show
AWAY = 0.64  # m


def finer_scan(source: Path, voxel: float) -> tuple[np.ndarray, np.ndarray]:
    """((V, 3) m, (F, 3)) in the frame of the scan file `source`, fused on a grid of `voxel` (m)."""
    body = clean(read_scan(source))
    low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
    middle = 0.5 * (low + high)
    views = [
        look_at(
            middle + AWAY * np.array([np.sin(turn), 0.0, np.cos(turn)]) + height * UP, middle + 0.4 * height * UP, UP
        )
        for height in HEIGHTS
        for turn in AZIMUTHS
    ]
    images = take(body.vertices, body.faces, views, DepthCamera(), np.random.default_rng(3))
    vertices, faces, _ = without_small_pieces(*fuse(images, low - voxel, high + voxel, voxel), smallest=80)
    return vertices, faces


def write_ply(path: Path, vertices: np.ndarray, faces: np.ndarray) -> Path:
    """A binary PLY with vertex colours, as scanning programs write it."""
    grey = np.full((len(vertices), 4), 180, dtype=np.uint8)
    path.write_bytes(trimesh.Trimesh(vertices, faces, vertex_colors=grey, process=False).export(file_type="ply"))
    return path
