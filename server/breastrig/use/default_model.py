"""The model that comes with BreastRig, read and made ready when this module is imported.

The fork server imports it, so that the process of each task finds the model and what never changes about it (groups of
vertices, weights of observations, what is expected of bodies, its part of fitted.glb) instead of computing them anew: a
sixth of a fit.
"""

from contextlib import suppress

import numpy as np

from breastrig.core.errors import BadModel
from breastrig.core.stances import AUTO, STANCES
from breastrig.drawings.skin_maps.lying_motion import lying_motion
from breastrig.energies.folding import pressed_edges
from breastrig.fitting.body.expected_body import body_terms
from breastrig.fitting.body.landmarks import landmark_errors
from breastrig.fitting.body.refine import hidden_skin, precompute_layers, trunk_depth
from breastrig.fitting.fit import observation_weights
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.uncertainty.radii import calibration
from breastrig.fitting.verdicts.verdict import verdict_limits
from breastrig.gltf.lines.ribbon import ribbons
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.gltf.skinned import skinned_document
from breastrig.relief.limits import relief
from breastrig.rig.body_statistics import body_statistics
from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.state import BodyState
from breastrig.rig.vertex_groups import vertex_groups
from breastrig.use.folder.fit_files import library_versions


def precompute(rig: Rig) -> None:
    """Computes what fits of this model share."""
    recipe, state = load_recipe("default"), BodyState(rig, rest_parameters(rig))
    _ = state.posed.rows(np.zeros(1, dtype=np.int64), np.ones((1, 3))), state.chordal_deviation, vertex_groups(rig)
    for every in {stage.every for stage in recipe.stages}:
        observation_weights(rig, recipe.observations, every)
    if recipe.shapes.folding is not None:
        pressed_edges(rig, recipe.shapes.folding.least)
    _ = lying_motion(rig), body_statistics(rig), calibration(rig), verdict_limits(rig), relief()
    _ = trunk_depth(rig), library_versions()
    for stance in STANCES:
        if stance != AUTO:
            hidden_skin(rig, stance)
            landmark_errors(rig, stance)
            body_terms(rig, recipe.shapes, recipe.scales, recipe.body, stance)
    precompute_layers(rig.template, rig.faces)
    skinned_document(rig, {})
    for drawing in rig.drawings[:1]:  # what a fit draws when it is not asked
        ribbons(rig, drawing)


with suppress(BadModel):  # reported when a fit needs it
    precompute(read_rig(default_rig_path()))
