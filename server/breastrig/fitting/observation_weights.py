"""How many independent observations of the scan each model vertex stands for (docs/decisions/0010).

A vertex counts by the area around it in the rest pose, in units of the square of the spacing at which the preset takes
observations to be independent: narrow in the regions that matter most, growing with the distance from them.  A stage
that looks at every nth vertex gives each of these the area of its left-out neighbours.  Each vertex is to lie above the
scan by the chordal deviation of its triangles (geometry/surface_points.py), so that a finer model fits the same.
"""

from functools import lru_cache

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array
from breastrig.fitting.recipe import Observations
from breastrig.geometry.normals import face_areas
from breastrig.rig.model import Rig


@lru_cache(maxsize=16)
def observation_weights(rig: Rig, observations: Observations | None, every: int) -> Array:
    """(V,), read-only: 0 for the vertices that a stage leaves out; without settings each vertex counts as one."""
    if every == 1:
        weights: Array = np.ones(len(rig.template)) if observations is None else _per_vertex(rig, observations)
    else:
        chosen = np.arange(0, len(rig.template), every)
        nearest = cKDTree(rig.template[chosen]).query(rig.template)[1]
        weights = np.zeros(len(rig.template))
        weights[chosen] = np.bincount(nearest, observation_weights(rig, observations, 1), len(chosen))
    weights.flags.writeable = False
    return weights


def _per_vertex(rig: Rig, observations: Observations) -> Array:
    """(V,) a third of what each triangle around a vertex counts."""
    faces = rig.faces
    spacing = np.full(len(faces), observations.spacing)
    focus = [vertices for name, vertices in rig.regions.items() if name in observations.focus and len(vertices)]
    if focus:
        inside = np.zeros(len(rig.template), dtype=np.bool_)
        inside[np.concatenate(focus)] = True
        away, _ = cKDTree(rig.template[inside]).query(rig.template[faces].mean(axis=1))
        distances = np.where(inside[faces].all(axis=1), 0.0, away)
        spacing = np.minimum(observations.focus_spacing + observations.growth * distances, spacing)
    share = face_areas(rig.template, faces) / spacing**2 / 3.0
    return np.asarray(np.bincount(faces.ravel(), np.repeat(share, 3), len(rig.template)), dtype=np.float64)
