"""Other methods from the same start: rigid iterative closest points, and a free-form registration.

Both get the same similarity from the true landmarks as our fit; the free-form one (Amberg et al., 2007, in trimesh) is
given the landmarks as well. They deform the same template, so all numbers are of the same kind.
"""

import time
from typing import Any

import numpy as np
import trimesh

from breastrig.core.arrays import Array
from breastrig.core.errors import FitFailed
from breastrig.correspondence.match import MatchRules, match
from breastrig.fitting.recipe import Recipe
from breastrig.geometry.normals import vertex_normals
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama
from breastrig.rig.skinning import pose
from breastrig_studies.studies.case import Scene

RIGID_STEPS = 100  # at most
STILL = 1e-5  # m; the mean distance changes by less: done
RULES = MatchRules(method="tree", max_distance=0.05, max_angle=1.05)  # the paper's thresholds


def _rigid(scene: Scene, vertices: Array, rig: Rig) -> Array:
    """(V, 3) m after turning and shifting alone."""
    previous = np.inf
    for _ in range(RIGID_STEPS):
        found = match(scene.target, vertices, vertex_normals(vertices, rig.faces), RULES)
        mean = found.distances.mean() if len(found.distances) else np.nan
        if not np.isfinite(mean):
            raise FitFailed("The model found no skin of the scan near it.")
        if abs(previous - mean) < STILL:
            break
        previous = mean
        source = vertices[found.vertices]
        rotation = umeyama(source, found.points).rotation
        vertices = (vertices - source.mean(axis=0)) @ rotation.T + found.points.mean(axis=0)
    return vertices


def _free_form(scene: Scene, vertices: Array, rig: Rig) -> Array:
    """(V, 3) m by trimesh's nricp_amberg with its own settings."""
    names = tuple(scene.landmarks)
    points = rig.landmark_points(names)
    source = trimesh.Trimesh(vertices, rig.faces, process=False)
    goal = trimesh.Trimesh(scene.target.vertices, scene.target.faces, process=False)
    return np.asarray(
        trimesh.registration.nricp_amberg(
            source,
            goal,
            source_landmarks=(points.faces, points.barycentric),
            target_positions=np.array([scene.landmarks[name] for name in names]),
            use_faces=False,  # its search on faces needs a package that is not ours; points are quicker as well
        )
    )


METHODS = {"rigid": _rigid, "nricp_amberg": _free_form}


def peer(scene: Scene, rig: Rig, recipe: Recipe, method: str) -> dict[str, Any]:
    """One method from our start; the recipe plays no part."""
    first = pose(rig, scene.start(rig, scene.landmarks))
    began = time.process_time()
    vertices = METHODS[method](scene, first, rig)
    seconds = time.process_time() - began
    if not np.isfinite(vertices).all():
        raise FitFailed("The result is not finite.")
    return scene.numbers(rig, vertices) | {"time_s": round(seconds, 4)}
