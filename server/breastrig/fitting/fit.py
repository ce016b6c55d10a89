"""The registration: match, build the terms, one damped Newton step, yield; stage after stage.

A generator of frozen iterates is the only way to run a fit: the command line, the service and the tests all
consume it, and whoever stops consuming cancels the fit.  Nothing here prints, stores or draws.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.correspondence.match import Correspondences, MatchRules, match
from breastrig.correspondence.target import ScanTarget
from breastrig.energies.joint_limits import JointLimits
from breastrig.energies.joint_rest import JointRest
from breastrig.energies.landmarks import Landmarks
from breastrig.energies.point_to_plane import PointToPlane
from breastrig.energies.point_to_point import PointToPoint
from breastrig.energies.scale_prior import ScalePrior
from breastrig.energies.shape_prior import ShapePrior
from breastrig.energies.symmetry import Symmetry
from breastrig.fitting.recipe import Range, Recipe, Stage
from breastrig.geometry.normals import VertexNormals
from breastrig.least_squares.newton import Bounds, Status, newton_step
from breastrig.least_squares.problem import ResidualTerm
from breastrig.least_squares.robust import KERNELS
from breastrig.rig.joints import Joints
from breastrig.rig.model import Rig
from breastrig.rig.parameters import BONE_DOFS, RigParameters
from breastrig.rig.skinning import posed

MIN_MATCHES = 30  # fewer cannot hold 136 unknowns, whatever the priors


@dataclass(frozen=True, eq=False)
class FitIterate:
    """One state of a fit, in the frame of the target (m)."""

    iteration: int  # 0 is the start
    stage: str
    parameters: RigParameters
    energy: float
    mean_distance: float  # m, over the accepted matches; nan when there are none
    coverage: float  # share of the model's vertices with an accepted match
    landmark_distance: float | None  # m, mean over the picked landmarks
    elapsed_s: float
    status: Status  # RUNNING on all but the last


@dataclass(frozen=True, eq=False)
class FitTask:
    """What is to be fitted to what."""

    rig: Rig
    target: ScanTarget
    start: RigParameters
    recipe: Recipe
    landmarks: dict[str, Array]  # name -> (3,) m, in the target's frame
    stance: str = "standing"  # standing | supine


def _along(pair: Range, progress: float) -> float:
    return float(pair[0] * (pair[1] / pair[0]) ** progress)


def _shape_sigma(task: FitTask) -> tuple[Array, Array]:
    """(S,), (S,): expected size and mean of every shape weight."""
    settings, shapes = task.recipe.shapes, task.rig.shapes
    sigma = np.array([settings.sigma or shape.sigma * settings.factor for shape in shapes])
    gravity = np.array([shape.kind == "gravity" for shape in shapes], dtype=np.bool_)
    if task.stance == "supine":
        return sigma, np.where(gravity, settings.supine_gravity_mean, 0.0)
    return np.where(gravity, sigma * settings.standing_gravity_factor, sigma), np.zeros(len(shapes))


def _priors(task: FitTask, joints: Joints) -> list[ResidualTerm[RigParameters]]:
    rig, recipe = task.rig, task.recipe
    sigma, mean = _shape_sigma(task)
    terms: list[ResidualTerm[RigParameters]] = [
        ScalePrior(rig, recipe.scales.sigma, recipe.scales.neighbour_sigma or np.inf),
        ShapePrior(sigma, mean),
    ]
    if recipe.joints.limit_sigma is not None:
        terms.append(JointLimits(joints, recipe.joints.limit_sigma))
    if recipe.shapes.symmetry_sigma or recipe.scales.symmetry_sigma:
        terms.append(Symmetry(rig, recipe.shapes.symmetry_sigma or np.inf, recipe.scales.symmetry_sigma or np.inf))
    return terms


def _joints(task: FitTask) -> Joints:
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


def _bounds(task: FitTask, x: RigParameters) -> Bounds:
    """Room left for the scales and the shape weights."""
    rig, constraint = task.rig, task.recipe.shapes.constraint
    lower, upper = np.full(x.dof, -np.inf), np.full(x.dof, np.inf)
    bones = len(rig.bones)
    for side, values in ((lower, [b.scale_min for b in rig.bones]), (upper, [b.scale_max for b in rig.bones])):
        side[: BONE_DOFS * bones].reshape(bones, BONE_DOFS)[:, 6:9] = np.array(values) - x.scales
    first = BONE_DOFS * bones
    if constraint == "box":
        lower[first:] = np.array([shape.min for shape in rig.shapes]) - x.weights
        upper[first:] = np.array([shape.max for shape in rig.shapes]) - x.weights
    equalities = None
    if constraint == "simplex":  # weights and the template's remaining share are >= 0 and sum to one
        lower[first:] = -x.weights
        if x.weights.sum() >= 1.0 - 1e-9:
            equalities = np.zeros((1, x.dof))
            equalities[0, first:] = 1.0
    return Bounds(np.minimum(lower, 0.0), np.maximum(upper, 0.0), equalities)


def _onto_simplex(x: RigParameters) -> RigParameters:
    """Weights projected onto {α >= 0, Σα <= 1} (Duchi et al., 2008)."""
    weights = np.maximum(x.weights, 0.0)
    if weights.sum() > 1.0:
        ordered = np.sort(weights)[::-1]
        excess = (np.cumsum(ordered) - 1.0) / np.arange(1, len(ordered) + 1)
        weights = np.maximum(weights - excess[np.flatnonzero(ordered > excess)[-1]], 0.0)
    return RigParameters(x.rotations, x.translations, x.scales, weights)


def _matches(task: FitTask, stage: Stage, progress: float, vertices: Array, normals: Array) -> Correspondences:
    """Matches of this stage's share of the model's vertices."""
    rules = MatchRules(
        stage.method, _along(stage.max_distance, progress), stage.max_angle, reject_border=stage.reject_border
    )
    if stage.every == 1:
        return match(task.target, vertices, normals, rules)
    chosen = np.arange(0, len(vertices), stage.every)
    found = match(task.target, vertices[chosen], normals[chosen], rules)
    return replace(found, vertices=chosen[found.vertices])


def _free(task: FitTask, stage: Stage, dof: int) -> Booleans:
    free = np.ones(dof, dtype=np.bool_)
    bones = len(task.rig.bones)
    free[: BONE_DOFS * bones].reshape(bones, BONE_DOFS)[:, 6:9] = stage.free_scales
    free[BONE_DOFS * bones :] = [shape.kind in stage.free_shapes for shape in task.rig.shapes]
    return free


def _scaling(task: FitTask, dof: int) -> Array:
    """(P,) inverse square of each unknown's natural size: 0.1 rad, 10 mm, the priors' sigmas."""
    bones = len(task.rig.bones)
    sizes = np.zeros(dof)
    blocks = sizes[: BONE_DOFS * bones].reshape(bones, BONE_DOFS)
    blocks[:, 0:3], blocks[:, 3:6], blocks[:, 6:9] = 0.1, 0.01, task.recipe.scales.sigma
    sizes[BONE_DOFS * bones :] = _shape_sigma(task)[0]
    return np.asarray(sizes**-2)


def _terms(
    task: FitTask,
    stage: Stage,
    progress: float,
    vertices: Array,
    matches: Correspondences,
    priors: list[ResidualTerm[RigParameters]],
) -> list[ResidualTerm[RigParameters]]:
    weights = KERNELS[stage.kernel](matches.distances / _along(stage.kernel_scale, progress))
    terms = [*priors, PointToPlane(task.rig, matches, weights, _along(stage.data_sigma, progress))]
    if stage.along_sigma is not None:
        terms.append(PointToPoint(task.rig, matches, weights, _along(stage.along_sigma, progress)))
    if task.landmarks:
        names = tuple(task.landmarks)
        sigma = np.full(len(names), _along(stage.landmark_sigma, progress))
        targets, points = np.array([task.landmarks[name] for name in names]), task.rig.landmark_points(names)
        if stage.landmark_kernel_scale is not None:
            gaps = np.linalg.norm(points.positions(vertices, task.rig.faces) - targets, axis=1)
            trust = KERNELS["geman_mcclure"](gaps / _along(stage.landmark_kernel_scale, progress))
            sigma = sigma / np.sqrt(np.maximum(trust, 1e-6))
        terms.append(Landmarks(task.rig, points, targets, sigma))
    return terms


def fit_iterates(task: FitTask) -> Iterator[FitIterate]:
    """Yields the start as iteration 0, then one iterate a step; the last one's status says why it stopped."""
    began = time.perf_counter()
    rig, recipe = task.rig, task.recipe
    names = tuple(task.landmarks)
    landmark_points = rig.landmark_points(names) if names else None
    picked = np.array([task.landmarks[name] for name in names])
    normals_of = VertexNormals(rig.faces, len(rig.template))
    joints = _joints(task)
    priors, held, scaling = _priors(task, joints), [JointRest(joints)], _scaling(task, task.start.dof)
    x, iteration, quiet, previous = task.start, 0, 0, np.inf
    energy = float("nan")

    def iterate(stage: Stage, matches: Correspondences, status: Status) -> FitIterate:
        vertices = posed(rig, x).vertices
        gap = None
        if landmark_points is not None:
            gap = float(np.linalg.norm(landmark_points.positions(vertices, rig.faces) - picked, axis=1).mean())
        mean = float(matches.distances.mean()) if len(matches.distances) else float("nan")
        coverage = len(matches.distances) * stage.every / len(vertices)
        return FitIterate(iteration, stage.name, x, energy, mean, coverage, gap, time.perf_counter() - began, status)

    for stage in recipe.stages:
        free = _free(task, stage, x.dof)
        last_stage = stage is recipe.stages[-1]
        quiet = 0
        for step_number in range(stage.iterations):
            progress = min(step_number / max(stage.tighten - 1, 1), 1.0)
            vertices = posed(rig, x).vertices
            matches = _matches(task, stage, progress, vertices, normals_of(vertices))
            mean = float(matches.distances.mean()) if len(matches.distances) else np.inf
            still = progress == 1.0 and abs(mean - previous) < recipe.stop.distance_change_m
            quiet = quiet + 1 if still else 0
            previous = mean
            if last_stage and quiet >= recipe.stop.patience:
                yield iterate(stage, matches, Status.CONVERGED)
                return
            if len(matches.distances) < MIN_MATCHES and not names:
                yield iterate(stage, matches, Status.STALLED)
                return
            yield iterate(stage, matches, Status.RUNNING)
            terms = _terms(task, stage, progress, vertices, matches, priors)
            step = newton_step(
                terms, held, x, scaling=scaling, damping=recipe.damping, bounds=_bounds(task, x), free=free
            )
            if step.status is Status.NOT_FINITE:
                yield iterate(stage, matches, Status.NOT_FINITE)
                return
            x, energy = step.x, step.energy
            if recipe.shapes.constraint == "simplex":
                x = _onto_simplex(x)
            iteration += 1
            if step.status is Status.STALLED and last_stage:
                yield iterate(stage, matches, Status.STALLED)
                return
    vertices = posed(rig, x).vertices
    matches = _matches(task, stage, 1.0, vertices, normals_of(vertices))
    yield iterate(stage, matches, Status.OUT_OF_ITERATIONS)
