"""Skin that a scan asks to fold stays unfolded: triangles of the fitted model keep the side that faces outwards."""

import numpy as np

from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.fit import FitTask, fit_iterates
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.geometry.normals import face_normals
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters, rest_parameters
from breastrig.rig.skinning import pose, shaped

# What one lying body's scan was best met with: the skin of both sides is drawn over the midline.
OVER_THE_MIDLINE = {
    "supine_spread_L": 1.63,
    "supine_spread_R": 1.66,
    "position_lateral_L": -0.81,
    "position_lateral_R": -0.76,
    "muscle": 0.72,
}


def folded(rig: Rig) -> RigParameters:
    rest = rest_parameters(rig)
    weights = np.array([OVER_THE_MIDLINE.get(name, 0.0) for name in rig.shape_names])
    return RigParameters(rest.rotations, rest.translations, rest.scales, weights)


def turned_over(rig: Rig, x: RigParameters) -> int:
    """How many triangles the shapes turn over."""
    facing, now = face_normals(rig.template, rig.faces), face_normals(shaped(rig, x.weights), rig.faces)
    return int((np.einsum("fi,fi->f", facing, now) < 0.0).sum())


def fitted(rig: Rig, recipe: Recipe) -> RigParameters:
    """To the folded body itself, from where it is."""
    x = folded(rig)
    target = ScanTarget(pose(rig, x), rig.faces)
    *_, last = fit_iterates(FitTask(rig, target, x, recipe, {}, stance="supine"))
    assert last.is_finite
    return last.parameters


def test_a_scan_that_would_fold_the_breastbone_is_fitted_without_a_fold(torso: Rig) -> None:
    recipe = load_recipe("default")
    free = recipe.model_copy(update={"shapes": recipe.shapes.model_copy(update={"folding": None})})
    assert turned_over(torso, folded(torso)) > 10
    assert turned_over(torso, fitted(torso, free)) > 10  # without the term the fold stays
    assert turned_over(torso, fitted(torso, recipe)) == 0


def test_the_paper_s_own_way_knows_nothing_of_folds() -> None:
    assert load_recipe("paper").shapes.folding is None
