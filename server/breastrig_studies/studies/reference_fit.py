"""The reference location of each model vertex: the model fitted to a case's true surface with all true landmarks.

It is no measurement of the program, which never sees that surface, but the reference for unseen parts and for the
statistics of bodies: its skin lies on the true one, and along the skin it is as good as landmarks and shapes are.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.body.refine import refined
from breastrig.fitting.recipe import Recipe
from breastrig.fitting.solve import checked_iterates
from breastrig.fitting.task import FitTask
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import pose
from breastrig_studies.studies.case import Scene, ready

SIGMA = 0.002  # m; a true surface has no noise, only what the model cannot show
REACH = 0.03  # m; nothing else is near, so the back may be far at first


@dataclass(frozen=True, eq=False)
class ReferenceFit:
    """The reference fit, in the scan's frame (m)."""

    parameters: RigParameters
    vertices: Array  # (V, 3), moved onto the true skin


def reference_fit(scene: Scene, rig: Rig, recipe: Recipe) -> ReferenceFit | None:
    """The reference fit; None where no true surface is known."""
    if scene.truth is None:
        return None
    target = ready(ScanTarget(scene.truth.vertices, np.asarray(scene.truth.triangles)))
    close = recipe.observed.model_copy(update={"skin": SIGMA, "farthest": REACH})
    start = scene.start(rig, scene.landmarks)
    known = recipe.model_copy(update={"observed": close, "body": None})  # what is estimated from it must not be in it
    *_, last = checked_iterates(FitTask(rig, target, start, known, {}, scene.case.stance).with_picks(scene.landmarks))
    vertices = refined(target, pose(rig, last.parameters), rig.faces).vertices
    return ReferenceFit(last.parameters, vertices)
