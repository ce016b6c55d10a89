"""Writes what is known of bodies (fitting/body): mean and covariance of scales and shapes over a folder of cases.

    breastrig evaluate --warped 73 --half choose COHORT -o DIR --quick
    python -m breastrig_studies.body_statistics DIR/warped

Each body is seen twice, as she is and mirrored, so that no side is preferred.  Standing and lying bodies each lose
their own mean: the prior's centre knows the stance already.  The covariance is kept as its strongest directions.
"""

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.body_statistics import SCHEMA
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig_studies.cohort import read_cohort
from breastrig_studies.studies.case import read_scene
from breastrig_studies.studies.reference_fit import reference_fit

FILE = default_rig_path().with_suffix(".known") / "bodies.json"
KEPT = 0.98  # of the variance


def mirrored(rig: Rig) -> Integers:
    """(N,) where the scales and weights of the other side stand; the scales' axes are alike on both sides."""
    bones = [rig.bone_names.index(bone.mirror) for bone in rig.bones]
    shapes = [rig.shape_names.index(shape.mirror) for shape in rig.shapes]
    scales = (3 * np.array(bones)[:, None] + np.arange(3)).ravel()
    return np.concatenate([scales, 3 * len(bones) + np.array(shapes, dtype=np.int64)])


def statistics(rig: Rig, bodies: Sequence[tuple[str, RigParameters]]) -> dict[str, Any]:
    """The document of (stance, parameters) of bodies."""
    rows = np.array([np.concatenate([x.scales.ravel(), x.weights]) for _, x in bodies])
    stances = np.array([stance for stance, _ in bodies] * 2)
    rows = np.concatenate([rows, rows[:, mirrored(rig)]])
    scales = 3 * len(rig.bones)
    deviations = rows.copy()
    for stance in np.unique(stances):
        deviations[stances == stance] -= rows[stances == stance].mean(axis=0)
    return {
        "schema": SCHEMA,
        "bodies": len(bodies),
        "bones": list(rig.bone_names),
        "shapes": list(rig.shape_names),
        "mean_scales": np.round(rows[:, :scales].mean(axis=0), 4).tolist(),
        "factors": np.round(_strongest(deviations), 5).tolist(),
    }


def _strongest(deviations: Array) -> Array:
    """(K, N) whose FᵀF is nearly the covariance of the (M, N) deviations."""
    _, sizes, directions = np.linalg.svd(deviations / np.sqrt(len(deviations)), full_matrices=False)
    share = np.cumsum(sizes**2) / (sizes**2).sum()
    count = int(np.searchsorted(share, KEPT)) + 1
    return np.asarray(sizes[:count, None] * directions[:count])


def main(folder: Path, file: Path = FILE) -> None:
    """Fits every case of the folder and writes the file."""
    rig, recipe = read_rig(default_rig_path()), load_recipe("default")
    bodies = []
    for case in read_cohort(folder):
        found = reference_fit(read_scene(case), rig, recipe)
        if found is not None:
            bodies.append((case.stance, found.parameters))
    file.write_text(json.dumps(statistics(rig, bodies), indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
