"""What a fit minimises for one scan: the observations that it gives, what is expected of a body, and where to stop.

At a state of the model a stage of the recipe asks for matches and makes terms of them (equations 7 to 9); the priors
(equations 4 and 5 and ours) and joints (equation 6) do not depend on the scan.  A fit of two stances has two of these
problems (two_stances.py), the fit of one scan one; bounds and free unknowns stand here too, so that both move alike.
"""

import time
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.core.stances import PRONE, STANDING
from breastrig.correspondence.match import Correspondences, MatchRules, match
from breastrig.energies.body_prior import BodyPrior
from breastrig.energies.folding import Folding
from breastrig.energies.joint_limits import JointLimits
from breastrig.energies.joint_rest import JointRest
from breastrig.energies.landmarks import Landmarks
from breastrig.energies.point_to_plane import PointToPlane
from breastrig.energies.point_to_point import PointToPoint
from breastrig.energies.scale_prior import ScalePrior
from breastrig.energies.shape_prior import ShapePrior
from breastrig.energies.symmetry import Symmetry
from breastrig.energies.table_contact import TableContact
from breastrig.fitting.body.mirrored_landmarks import MirroredLandmark, mirrored_landmarks, mirrored_terms
from breastrig.fitting.body.relief import observe_relief, relief_terms
from breastrig.fitting.observation_weights import observation_weights
from breastrig.fitting.recipe import Body, Hanging, Range, Scales, Shapes, Stage
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.least_squares.newton import Status, System, Value, assemble, value
from breastrig.least_squares.problem import KERNELS, Constraint, ResidualTerm
from breastrig.least_squares.quadratic_program import Bounds
from breastrig.rig.blocks import block
from breastrig.rig.body_statistics import body_statistics
from breastrig.rig.joints import Joints
from breastrig.rig.model import Rig
from breastrig.rig.parameters import BONE_DOFS, RigParameters
from breastrig.rig.skinning import pose
from breastrig.rig.stance_priors import in_stance, mean_weights, rest_turns
from breastrig.rig.state import BodyState

Terms = list[ResidualTerm[BodyState]]

MIN_MATCHES = 30  # fewer cannot hold 136 unknowns, whatever the priors


def along(pair: Range, progress: float) -> float:
    """A range's value when the stage has tightened by `progress` (0 to 1)."""
    return float(pair[0] * (pair[1] / pair[0]) ** progress)


@dataclass(frozen=True, eq=False)
class Picks:
    """L picked landmarks."""

    points: SurfacePoints  # (L) on the model
    targets: Array  # (L, 3) m
    unsure: Array  # (L,) m, expected error beyond a click's

    @staticmethod
    def of(task: FitTask) -> "Picks | None":
        """None without any."""
        if not task.landmarks:
            return None
        points, targets = task.rig.landmark_points(tuple(task.landmarks)), np.array([*task.landmarks.values()])
        return Picks(points, targets, np.array([task.landmark_errors.get(name, 0.0) for name in task.landmarks]))

    def gaps(self, rig: Rig, vertices: Array) -> Array:
        """(L,) m from the landmarks of a model with these (V, 3) m vertices."""
        return np.asarray(np.linalg.norm(self.points.positions(vertices, rig.faces) - self.targets, axis=1))


class ScanProblem:
    """One scan's part of a fit."""

    def __init__(self, task: FitTask, *, partners: bool = True) -> None:
        """`partners`: whether a pick tells where its partner is; what judges picks lets none vouch for itself."""
        self.task, self._partners = task, partners
        self._joints = expected_joints(task)
        self.priors = prior_terms(task, self._joints)
        self.held: list[Constraint[BodyState]] = [JointRest(self._joints)]
        self.scaling = step_scaling(task)
        self._picks = Picks.of(task)
        self.relief = task.relief
        self._mirrored: dict[str, MirroredLandmark] = {}
        self._began = time.perf_counter()

    def start(self) -> BodyState:
        """The task's start, moved to where the recipe allows its shape weights."""
        return BodyState(self.task.rig, allowed_start(self.task))

    def matches(self, stage: Stage, progress: float, state: BodyState) -> Correspondences:
        """Of this stage's share of the model's vertices."""
        vertices, normals = state.vertices, state.normals
        rules = MatchRules(
            stage.method, along(stage.max_distance, progress), stage.max_angle, reject_border=stage.reject_border
        )
        if stage.every == 1:
            return match(self.task.target, vertices, normals, rules)
        chosen = np.arange(0, len(vertices), stage.every)
        found = match(self.task.target, vertices[chosen], normals[chosen], rules)
        return replace(found, vertices=chosen[found.vertices])

    def lost(self, matches: Correspondences) -> bool:
        """Neither skin nor landmarks hold the model."""
        return len(matches.distances) < MIN_MATCHES and self._picks is None

    def terms(self, stage: Stage, progress: float, state: BodyState, matches: Correspondences) -> Terms:
        """All residuals at a state; those of scan and landmarks are made for it."""
        data = data_term(self.task, stage, progress, state, matches)
        picks = [] if self._picks is None else [landmark_term(self._picks, stage, progress, state)]
        if stage.relief is None and self.task.stance != PRONE:  # a prone body is found by its breasts
            return [*self.priors, data, *picks]
        if self.relief is None:
            self._look(state, [*self.priors, data], picks)
        relief = relief_terms(self.task.rig, self.relief or {}, stage)
        return [*self.priors, data, *picks, *relief, *mirrored_terms(self.task.rig, self._mirrored)]

    def _look(self, state: BodyState, others: Terms, picks: list[Landmarks]) -> None:
        """What else is known of landmarks: looked for once, where the first stage that asks for it begins."""
        self.relief = observe_relief(self.task, state)
        for term in picks if self._partners else []:
            self._mirrored = mirrored_landmarks(self.task, state, term, self.system(others, state), self.scaling)

    def system(self, terms: Terms, state: BodyState) -> System:
        """Gauss-Newton's quadratic model."""
        return assemble(terms, self.held, state)

    def value(self, terms: Terms, state: BodyState) -> Value:
        """The energy (equation 9)."""
        return value(terms, self.held, state)

    def free(self, stage: Stage) -> Booleans:
        """(P,) what the stage lets move."""
        rig = self.task.rig
        bones = len(rig.bones)
        free = np.ones(len(self.scaling), dtype=np.bool_)
        free[: BONE_DOFS * bones].reshape(bones, BONE_DOFS)[:, 6:9] = stage.free_scales
        free[BONE_DOFS * bones :] = [shape.kind in stage.free_shapes for shape in rig.shapes]
        for name in self.task.locked:
            free[block(rig, name)] = False
        return free

    def bounds(self, state: BodyState) -> Bounds:
        """Room left for the scales and the shape weights."""
        return step_bounds(self.task, state.x)

    def iterate(
        self, iteration: int, stage: Stage, state: BodyState, energy: float, matches: Correspondences, status: Status
    ) -> FitIterate:
        """What is reported of a state."""
        return FitIterate(
            iteration=iteration,
            stage=stage.name,
            parameters=state.x,
            energy=energy,
            mean_distance=mean_distance(matches, np.nan),
            coverage=len(matches.distances) * stage.every / len(state.vertices),
            landmark_distance=self._landmark_distance(state.vertices),
            elapsed_s=time.perf_counter() - self._began,
            status=status,
            relief=self.relief,
            hanging=self.task.hanging,
        )

    def _landmark_distance(self, vertices: Array) -> float | None:
        """m, mean over the picked landmarks; None without picks of a person."""
        return (
            None
            if self._picks is None or self.task.from_colour
            else float(self._picks.gaps(self.task.rig, vertices).mean())
        )


def mean_distance(matches: Correspondences, without: float) -> float:
    """m, mean over the accepted matches, or `without` when there are none."""
    return float(matches.distances.mean()) if len(matches.distances) else without


def projected(matches: Correspondences, vertices: Array) -> Correspondences:
    """The matches with each scan point moved along its tangent plane until it lies on its normal through the vertex.

    vertices: (V, 3) m, all of the model.
    """
    own = vertices[matches.vertices]
    heights = np.einsum("mi,mi->m", matches.normals, matches.points - own)
    return replace(matches, points=own + heights[:, None] * matches.normals)


def data_term(
    task: FitTask, stage: Stage, progress: float, state: BodyState, matches: Correspondences
) -> ResidualTerm[BodyState]:
    """The scan's observations, weighted by the skin that each stands for and by the stage's robust kernel.

    With weights by skin it is the model's surface that is to lie on the scan, not its vertices: these are aimed at as
    far above the scan as the triangles around them lie below (observation_weights.py).
    """
    counts = observation_weights(task.rig, task.recipe.observations, stage.every)[matches.vertices]
    weights = counts * KERNELS[stage.kernel](matches.distances / along(stage.kernel_scale, progress))
    sigma = along(stage.data_sigma, progress)
    if task.recipe.observations is not None:
        above = state.chordal_deviation[matches.vertices]
        matches = replace(matches, points=matches.points + above[:, None] * matches.normals)
    if stage.data_term == "point_to_projection":
        return PointToPoint(task.rig, projected(matches, state.vertices), weights, sigma)
    if stage.along_sigma is not None:
        return PointToPoint(task.rig, matches, weights, along(stage.along_sigma, progress), sigma)
    return PointToPlane(task.rig, matches, weights, sigma)


def landmark_term(picks: Picks, stage: Stage, progress: float, state: BodyState) -> Landmarks:
    """The picked landmarks, each with its expected error; far ones weaker where the stage has a kernel for them."""
    sigma = np.hypot(along(stage.landmark_sigma, progress), picks.unsure)
    if stage.landmark_kernel_scale is not None:
        scale = np.hypot(along(stage.landmark_kernel_scale, progress), picks.unsure)
        trust = KERNELS["geman_mcclure"](picks.gaps(state.rig, state.vertices) / scale)
        sigma = sigma / np.sqrt(np.maximum(trust, 1e-6))
    return Landmarks(state.rig, picks.points, picks.targets, sigma)


def expected_shapes(rig: Rig, settings: Shapes, stance: str) -> tuple[Array, Array]:
    """(S,), (S,): expected size and mean of every shape weight."""
    shapes, mean = in_stance(rig, stance).shapes, mean_weights(rig, stance)
    sigma = np.array([settings.sigma or shape.sigma * settings.factor for shape in shapes])
    gravity = np.array([shape.kind == "gravity" for shape in shapes], dtype=np.bool_)
    if stance == "supine":
        return sigma, np.where(gravity, settings.supine_gravity_mean, mean)
    return np.where(gravity & (stance == STANDING), sigma * settings.standing_gravity_factor, sigma), mean


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


def prior_terms(task: FitTask, joints: Joints) -> Terms:
    """The terms that no scan changes."""
    rig, recipe = task.rig, task.recipe
    hanging = (recipe.hanging, task.hanging) if recipe.hanging is not None and task.hanging else None
    terms = [*body_terms(rig, recipe.shapes, recipe.scales, recipe.body, task.stance, hanging)]
    if recipe.joints.limit_sigma is not None:
        terms.append(JointLimits(joints, recipe.joints.limit_sigma))
    if recipe.shapes.symmetry_sigma or recipe.scales.symmetry_sigma:
        terms.append(Symmetry(rig, recipe.shapes.symmetry_sigma or np.inf, recipe.scales.symmetry_sigma or np.inf))
    if recipe.shapes.folding is not None:
        terms.append(Folding(in_stance(rig, task.stance), recipe.shapes.folding.least, recipe.shapes.folding.sigma))
    contact = table_contact(task)
    return terms if contact is None else [*terms, contact]


@lru_cache(maxsize=16)
def body_terms(
    rig: Rig,
    shapes: Shapes,
    scales: Scales,
    body: Body | None,
    stance: str,
    hanging: tuple[Hanging, tuple[str, ...]] | None = None,
) -> tuple[ResidualTerm[BodyState], ...]:
    """What is expected of scales and shapes: by the statistics of bodies where the recipe and the rig have them.

    `hanging` names the shapes of breasts that were seen to hang: of the few such women the statistics tell nothing.
    """
    sigma, mean = expected_shapes(rig, shapes, stance)
    hangs = np.zeros(len(rig.shapes))  # standard deviations beyond those of the statistics
    if hanging is not None:
        settings, names = hanging
        chosen = [rig.shape_names.index(name) for name in names]
        hangs[chosen], mean[chosen] = settings.sigma, settings.weight
    known = body_statistics(rig) if body is not None else None
    if body is None or known is None:
        prior = ShapePrior(np.hypot(sigma, hangs), mean)
        return ScalePrior(rig, scales.sigma, scales.neighbour_sigma or np.inf), prior
    of_shapes = np.hypot(body.shape_factor * sigma, hangs)
    alone = np.concatenate([np.full(3 * len(rig.bones), body.scale_sigma), of_shapes])
    covariance = body.share * known.covariance + np.diag(alone**2)
    return (BodyPrior(rig, np.concatenate([known.mean_scales, mean]), covariance),)


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


def step_scaling(task: FitTask) -> Array:
    """(P,) inverse square of each unknown's natural size: 0.1 rad, 10 mm, the priors' sigmas."""
    bones = len(task.rig.bones)
    sizes = np.zeros(BONE_DOFS * bones + len(task.rig.shapes))
    blocks = sizes[: BONE_DOFS * bones].reshape(bones, BONE_DOFS)
    blocks[:, 0:3], blocks[:, 3:6], blocks[:, 6:9] = 0.1, 0.01, task.recipe.scales.sigma
    sizes[BONE_DOFS * bones :] = expected_shapes(task.rig, task.recipe.shapes, task.stance)[0]
    return np.asarray(sizes**-2)


def step_bounds(task: FitTask, x: RigParameters) -> Bounds:
    """Room left for the scales and the shape weights."""
    rig, constraint = in_stance(task.rig, task.stance), task.recipe.shapes.constraint
    lower, upper = np.full(x.dof, -np.inf), np.full(x.dof, np.inf)
    bones = len(rig.bones)
    for side, values in ((lower, [b.scale_min for b in rig.bones]), (upper, [b.scale_max for b in rig.bones])):
        side[: BONE_DOFS * bones].reshape(bones, BONE_DOFS)[:, 6:9] = np.array(values) - x.scales
    first = BONE_DOFS * bones
    if constraint == "box":
        lower[first:] = np.array([shape.min for shape in rig.shapes]) - x.weights
        upper[first:] = np.array([shape.max for shape in rig.shapes]) - x.weights
    rows = limits = None
    if constraint == "simplex":  # weights and the template's remaining share are >= 0 and sum to one
        lower[first:] = -x.weights
        rows, limits = np.zeros((1, x.dof)), np.array([max(1.0 - x.weights.sum(), 0.0)])
        rows[0, first:] = 1.0
    return Bounds(np.minimum(lower, 0.0), np.maximum(upper, 0.0), rows, limits)


def allowed_start(task: FitTask) -> RigParameters:
    """The task's start with its shape weights moved to where the recipe allows them; steps then keep them there."""
    x, constraint = task.start, task.recipe.shapes.constraint
    if constraint == "box":
        ranges = np.array([[shape.min, shape.max] for shape in in_stance(task.rig, task.stance).shapes])
        return replace(x, weights=np.clip(x.weights, ranges[:, 0], ranges[:, 1]))
    return replace(x, weights=onto_simplex(x.weights)) if constraint == "simplex" else x


def onto_simplex(weights: Array) -> Array:
    """(S,) the nearest weights in {α >= 0, Σα <= 1} (Duchi et al., 2008)."""
    weights = np.maximum(weights, 0.0)
    if weights.sum() > 1.0:
        ordered = np.sort(weights)[::-1]
        excess = (np.cumsum(ordered) - 1.0) / np.arange(1, len(ordered) + 1)
        weights = np.maximum(weights - excess[np.flatnonzero(ordered > excess)[-1]], 0.0)
    return weights
