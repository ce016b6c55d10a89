"""Landmarks that a scan's form shows beside its surface: the model slides along smooth skin, hollows hold it.

A fit that has found the form looks once for the hollows near its landmarks (relief/observe.py), and goes on with what
it has seen as observations of these landmarks, each with its own covariance.  They are no picks: nobody is asked about
them, and a pick, or what colour shows of the same landmark, is more exact and takes their place.
"""

import numpy as np

from breastrig.fitting.task import FitTask
from breastrig.geometry.unit_vectors import unit_vectors
from breastrig.relief.observe import Expected, SeenHollow, seen_hollows
from breastrig.rig.similarity import umeyama
from breastrig.rig.state import BodyState


def look_for_hollows(task: FitTask, state: BodyState) -> dict[str, SeenHollow]:
    """What the scan shows of the landmarks that nobody picked, expected where the model has them now."""
    rig = task.rig
    points = rig.landmark_points()
    places = points.positions(state.vertices, rig.faces)
    if len(places) < 3 or not np.isfinite(places).all():
        return {}
    outwards = unit_vectors(points.positions(state.normals, rig.faces))
    axes = umeyama(points.positions(rig.template, rig.faces), places).rotation
    expected = {
        name: Expected(places[k], outwards[k])
        for k, name in enumerate(rig.landmark_names)
        if name not in task.landmarks
    }
    return seen_hollows(task.target, expected, axes)
