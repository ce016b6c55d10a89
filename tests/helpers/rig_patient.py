"""Patients that the rig can show exactly: what is true of them is known for every vertex."""

import numpy as np

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import pose
from helpers.random_pose import random_parameters
from helpers.subdivide import smoothly_subdivided, subdivided


def patient(rig: Rig, seed: int, smooth: bool = False) -> tuple[ScanTarget, dict[str, Array], Array]:
    """A random patient of the rig: her finer scan, her landmarks, and where each model vertex truly is.

    Between the vertices her skin is as flat as the rig's triangles, or smooth.
    """
    x = random_parameters(rig, np.random.default_rng(seed), turn=0.06, move=0.0, scale=0.03, shape=0.7)
    lower, upper = (np.array([getattr(shape, side) for shape in rig.shapes]) for side in ("min", "max"))
    vertices = pose(rig, RigParameters(x.rotations, x.translations, x.scales, np.clip(x.weights, lower, upper)))
    fine, triangles = (smoothly_subdivided if smooth else subdivided)(vertices, rig.faces)
    centre = fine.mean(axis=0)
    landmarks = rig.landmark_points().positions(vertices, rig.faces) - centre
    target = ScanTarget(fine - centre, triangles)
    return target, dict(zip(rig.landmark_names, landmarks, strict=True)), vertices - centre
