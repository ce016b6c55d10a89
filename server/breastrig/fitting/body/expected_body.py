"""The prior of scales and shapes before any scan: of all patients, and of those of a cohort (decision 0027)."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import STANDING
from breastrig.energies.body_prior import BodyPrior
from breastrig.energies.folding import Folding
from breastrig.energies.scale_prior import ScalePrior
from breastrig.energies.shape_prior import ShapePrior
from breastrig.energies.symmetry import Symmetry
from breastrig.energies.table_contact import TableContact
from breastrig.fitting.recipe import Body, Hanging, Scales, Shapes
from breastrig.fitting.task import FitTask
from breastrig.least_squares.problem import ResidualTerm
from breastrig.least_squares.quadratic_program import Bounds
from breastrig.rig.blocks import shape_block
from breastrig.rig.body_statistics import body_statistics
from breastrig.rig.cohort_posterior import CohortPosterior, Gaussian, posterior_of
from breastrig.rig.cohort_prior import cohort_of
from breastrig.rig.joints import Joints
from breastrig.rig.model import Rig
from breastrig.rig.modes import mode_count
from breastrig.rig.parameters import BONE_DOFS, RigParameters
from breastrig.rig.skinning import pose
from breastrig.rig.stance_priors import in_stance, mean_weights, rest_turns
from breastrig.rig.state import BodyState


def expected_shapes(rig: Rig, settings: Shapes, stance: str) -> tuple[Array, Array]:
    """(S,), (S,): expected size and mean of every shape weight."""
    shapes, mean = in_stance(rig, stance).shapes, mean_weights(rig, stance)
    sigma = np.array([settings.sigma or shape.sigma * settings.factor for shape in shapes])
    gravity = np.array([shape.kind == "gravity" for shape in shapes], dtype=np.bool_)
    if stance == "supine":
        return sigma, np.where(gravity, settings.supine_gravity_mean, mean)
    return np.where(gravity & (stance == STANDING), sigma * settings.standing_gravity_factor, sigma), mean


def built_in_body(rig: Rig, shapes: Shapes, body: Body, stance: str) -> Gaussian | None:
    """The built-in prior of scales and shapes; None for a rig without statistics of bodies."""
    known, (sigma, mean) = body_statistics(rig), expected_shapes(rig, shapes, stance)
    if known is None:
        return None
    alone = np.concatenate([np.full(3 * len(rig.bones), body.scale_sigma), body.shape_factor * sigma])
    return Gaussian(np.concatenate([known.mean_scales, mean]), body.share * known.covariance + np.diag(alone**2))


@lru_cache(maxsize=16)
def cohort_posterior(rig: Rig, shapes: Shapes, body: Body, stance: str) -> CohortPosterior | None:
    """The posterior of the rig's cohort (rig/cohort_prior.py); None without one, or where it predicts no better."""
    cohort, built_in = cohort_of(rig), built_in_body(rig, shapes, body, stance)
    sums = None if cohort is None else cohort.stances.get(stance)
    if cohort is None or sums is None or built_in is None:
        return None
    return posterior_of(rig, sums, built_in)


def expected_body(rig: Rig, shapes: Shapes, body: Body, stance: str) -> Gaussian | None:
    """The built-in body; with a cohort the geometric mean of both, for the patient may be unlike them."""
    built_in, posterior = built_in_body(rig, shapes, body, stance), cohort_posterior(rig, shapes, body, stance)
    if built_in is None or posterior is None:
        return built_in
    own, theirs = (np.linalg.inv(each.covariance) for each in (built_in, posterior.expected))
    covariance = 2.0 * np.linalg.inv(own + theirs)
    mean = 0.5 * covariance @ (own @ built_in.mean + theirs @ posterior.expected.mean)
    return Gaussian(mean, 0.5 * (covariance + covariance.T))


def _expecting(rig: Rig, body: Gaussian, hanging: tuple[Hanging, tuple[str, ...]] | None) -> BodyPrior:
    """The body, and breasts that were seen to hang, of which its statistics tell little: few such women are in them."""
    mean, more = body.mean.copy(), np.zeros(len(body.mean))
    if hanging is not None:
        settings, names = hanging
        places = [3 * len(rig.bones) + rig.shape_names.index(name) for name in names]
        mean[places], more[places] = settings.weight, settings.sigma**2
    return BodyPrior(rig, mean, body.covariance + np.diag(more))


@lru_cache(maxsize=16)
def body_terms(
    rig: Rig,
    shapes: Shapes,
    scales: Scales,
    body: Body | None,
    stance: str,
    hanging: tuple[Hanging, tuple[str, ...]] | None = None,
) -> tuple[ResidualTerm[BodyState], ...]:
    """The prior terms of scales and shapes: by the statistics of bodies where the recipe and the rig have them.

    `hanging` names the shapes of breasts that were seen to hang.
    """
    known = None if body is None else expected_body(rig, shapes, body, stance)
    if known is not None:
        return (_expecting(rig, known, hanging),)
    sigma, mean = expected_shapes(rig, shapes, stance)
    if hanging is not None:
        chosen = [rig.shape_names.index(name) for name in hanging[1]]
        sigma[chosen], mean[chosen] = np.hypot(sigma[chosen], hanging[0].sigma), hanging[0].weight
    return ScalePrior(rig, scales.sigma, scales.neighbour_sigma or np.inf), ShapePrior(sigma, mean)


def step_scaling(task: FitTask) -> Array:
    """(P,) inverse square of each unknown's natural size: 0.1 rad, 10 mm, the priors' sigmas."""
    bones = len(task.rig.bones)
    sizes = np.ones(BONE_DOFS * bones + len(task.rig.shapes) + mode_count(task.rig))
    blocks = sizes[: BONE_DOFS * bones].reshape(bones, BONE_DOFS)
    blocks[:, 0:3], blocks[:, 3:6], blocks[:, 6:9] = 0.1, 0.01, task.recipe.scales.sigma
    sizes[shape_block(task.rig)] = expected_shapes(task.rig, task.recipe.shapes, task.stance)[0]
    return np.asarray(sizes**-2)


def step_bounds(task: FitTask, x: RigParameters) -> Bounds:
    """Room left for the scales and the shape weights."""
    rig = in_stance(task.rig, task.stance)
    lower, upper = np.full(x.dof, -np.inf), np.full(x.dof, np.inf)
    bones = len(rig.bones)
    for side, values in ((lower, [b.scale_min for b in rig.bones]), (upper, [b.scale_max for b in rig.bones])):
        side[: BONE_DOFS * bones].reshape(bones, BONE_DOFS)[:, 6:9] = np.array(values) - x.scales
    own = shape_block(rig)
    lower[own] = np.array([shape.min for shape in rig.shapes]) - x.weights
    upper[own] = np.array([shape.max for shape in rig.shapes]) - x.weights
    return Bounds(np.minimum(lower, 0.0), np.maximum(upper, 0.0))


def allowed_start(task: FitTask) -> RigParameters:
    """The task's start with its shape weights moved into the rig's ranges; steps then keep them there."""
    ranges = np.array([[shape.min, shape.max] for shape in in_stance(task.rig, task.stance).shapes]).reshape(-1, 2)
    return replace(task.start, weights=np.clip(task.start.weights, ranges[:, 0], ranges[:, 1]))


def expected_joints(task: FitTask) -> Joints:
    """The rig's joints with the recipe's expected sizes."""
    settings, rig = task.recipe.joints, in_stance(task.rig, task.stance)
    joints = tuple(
        replace(
            joint,
            rotation_sigma=settings.rotation_sigma or joint.rotation_sigma * settings.rotation_factor,
            translation_sigma=(
                joint.translation_sigma * settings.translation_factor
                if settings.translation_sigma is None
                else settings.translation_sigma
            ),
        )
        for joint in rig.joints
    )
    return Joints(task.rig, joints, rest_turns(task.rig, task.stance))


def prior_terms(task: FitTask) -> list[ResidualTerm[BodyState]]:
    """The terms that no scan changes, but for those of the joints."""
    rig, recipe = task.rig, task.recipe
    terms = [*body_terms(rig, recipe.shapes, recipe.scales, recipe.body, task.stance, _hanging_of(task))]
    if recipe.shapes.symmetry_sigma or recipe.scales.symmetry_sigma:
        terms.append(Symmetry(rig, recipe.shapes.symmetry_sigma or np.inf, recipe.scales.symmetry_sigma or np.inf))
    if recipe.shapes.folding is not None:
        terms.append(Folding(in_stance(rig, task.stance), recipe.shapes.folding.least, recipe.shapes.folding.sigma))
    contact = table_contact(task)
    return terms if contact is None else [*terms, contact]


def _hanging_of(task: FitTask) -> tuple[Hanging, tuple[str, ...]] | None:
    return (task.recipe.hanging, task.hanging) if task.recipe.hanging is not None and task.hanging else None


def table_contact(task: FitTask) -> TableContact | None:
    """The term of a lying back; None where no table is seen under it or nothing is known of the rig's back."""
    rig, settings, table = task.rig, task.recipe.lying, task.target.table
    back = rig.regions.get("back")
    if table is None or task.stance != "supine" or back is None:
        return None
    leading = np.argmax(rig.weights_by_bone[:, back], axis=0)
    groups = {name: back[leading == rig.bone_names.index(name)] for name in settings.heights if name in rig.bone_names}
    known = {name: group for name, group in groups.items() if len(group)}
    heights = np.array([settings.heights[name] for name in known])
    start = pose(rig, task.start) @ table.normal - table.height
    away = np.mean([start[group].mean() for group in known.values()] - heights) if known else np.inf
    if abs(away) > settings.reach:
        return None
    return TableContact(
        rig, table, tuple(known.values()), heights, settings.sigma, settings.profile_sigma, settings.floor_sigma
    )
