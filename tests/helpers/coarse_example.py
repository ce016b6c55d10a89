"""The example patient with half of the triangles, for browsers that draw without a graphics card: also a program.

    python coarse_example.py FOLDER

One vertex stands for all of a small cube; everything else is as it was.
"""

import shutil
import sys
from pathlib import Path

import numpy as np
import trimesh

from breastrig.core.assets import asset_folder

CUBE = 0.007  # in the unit of the example's files, metres


def coarse_example(folder: Path) -> None:
    """Writes FOLDER/STANCE/{scan.ply, landmarks.json, case.json}."""
    for source in sorted(asset_folder("example").glob("*/scan.ply")):
        place = folder / source.parent.name
        place.mkdir(parents=True)
        for name in ("landmarks.json", "case.json"):
            shutil.copy(source.with_name(name), place)
        (place / "scan.ply").write_bytes(_coarse(source).export(file_type="ply"))


def _coarse(source: Path) -> trimesh.Trimesh:
    scan = trimesh.load(source, process=False)
    cubes = np.round(np.asarray(scan.vertices) / CUBE).astype(np.int64)
    cube = np.unique(cubes, axis=0, return_inverse=True)[1].ravel()
    count = np.bincount(cube)

    def mean(values: np.ndarray) -> np.ndarray:
        """(V, K) of each vertex's; of each cube's."""
        return np.stack([np.bincount(cube, weights=column) / count for column in values.T], axis=1)

    faces = cube[np.asarray(scan.faces)]
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    faces = faces[np.sort(np.unique(np.sort(faces, axis=1), axis=0, return_index=True)[1])]
    colours = {}
    if scan.visual.kind == "vertex":
        colours["vertex_colors"] = np.round(mean(np.asarray(scan.visual.vertex_colors, dtype=np.float64))).astype(
            np.uint8
        )
    return trimesh.Trimesh(mean(np.asarray(scan.vertices)), faces, process=False, **colours)


if __name__ == "__main__":
    coarse_example(Path(sys.argv[1]))
