"""How many independent observations of the scan each model vertex stands for.

Vertices are samples of a surface.  If each counted as one observation, a model with four times as many would trust
the scan four times as much, against the same priors.  So a vertex counts by the skin around it in the rest pose, in
units of the square of the spacing at which the preset takes observations to be independent: narrow in the regions
that matter most, growing with the distance from them as the meshes of such models do.  A stage that looks at every
nth vertex only gives each of these the skin of its left-out neighbours.

The vertices alone would not do: on curved skin the triangles between them lie below it (0.14 mm in the mean, 1 mm on
the arms), and a model cut finer would have vertices there too.  So the term asks for the triangles' mean distance: each
vertex is to lie above the scan by the chordal deviation of its triangles (geometry/chordal_deviation.py).  A model with
each triangle cut in four then fits within 0.02 mm of the original where the scan is free of noise.  On the example
scans it is 0.09 mm (0.06 mm where there is scan), 0.18 and 0.15 mm without; fits to two halves of the finer model's
vertices differ by 0.18 and 0.15 mm, so what is left is noise that is sampled at other places.  Means over eight dev
scans, mm without and with it: vertices to the scan 0.91 0.92, to the true skin 1.05 1.04; scan to the model 1.21 1.18;
true skin to the model 2.67 2.63, of which inwards 0.64 0.46.
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
