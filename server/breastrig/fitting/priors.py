"""What is expected of a body before its scan is seen: the recipe's expected sizes on the rig's own data."""

from dataclasses import replace

import numpy as np

from breastrig.core.arrays import Array
from breastrig.energies.joint_limits import JointLimits
from breastrig.energies.scale_prior import ScalePrior
from breastrig.energies.shape_prior import ShapePrior
from breastrig.energies.symmetry import Symmetry
from breastrig.fitting.task import FitTask
from breastrig.least_squares.problem import ResidualTerm
from breastrig.rig.joints import Joints
from breastrig.rig.parameters import BONE_DOFS, RigParameters


def expected_shapes(task: FitTask) -> tuple[Array, Array]:
    """(S,), (S,): expected size and mean of every shape weight."""
    settings, shapes = task.recipe.shapes, task.rig.shapes
    sigma = np.array([settings.sigma or shape.sigma * settings.factor for shape in shapes])
    gravity = np.array([shape.kind == "gravity" for shape in shapes], dtype=np.bool_)
    if task.stance == "supine":
        return sigma, np.where(gravity, settings.supine_gravity_mean, 0.0)
    return np.where(gravity, sigma * settings.standing_gravity_factor, sigma), np.zeros(len(shapes))


def expected_joints(task: FitTask) -> Joints:
    """The rig's joints with the recipe's expected sizes."""
    settings, rig = task.recipe.joints, task.rig
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
    return Joints(rig, joints)


def prior_terms(task: FitTask, joints: Joints) -> list[ResidualTerm[RigParameters]]:
    """The terms that no scan changes."""
    rig, recipe = task.rig, task.recipe
    sigma, mean = expected_shapes(task)
    terms: list[ResidualTerm[RigParameters]] = [
        ScalePrior(rig, recipe.scales.sigma, recipe.scales.neighbour_sigma or np.inf),
        ShapePrior(sigma, mean),
    ]
    if recipe.joints.limit_sigma is not None:
        terms.append(JointLimits(joints, recipe.joints.limit_sigma))
    if recipe.shapes.symmetry_sigma or recipe.scales.symmetry_sigma:
        terms.append(Symmetry(rig, recipe.shapes.symmetry_sigma or np.inf, recipe.scales.symmetry_sigma or np.inf))
    return terms


def step_scaling(task: FitTask, dof: int) -> Array:
    """(P,) inverse square of each unknown's natural size: 0.1 rad, 10 mm, the priors' sigmas."""
    bones = len(task.rig.bones)
    sizes = np.zeros(dof)
    blocks = sizes[: BONE_DOFS * bones].reshape(bones, BONE_DOFS)
    blocks[:, 0:3], blocks[:, 3:6], blocks[:, 6:9] = 0.1, 0.01, task.recipe.scales.sigma
    sizes[BONE_DOFS * bones :] = expected_shapes(task)[0]
    return np.asarray(sizes**-2)
