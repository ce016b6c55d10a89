"""What a fit minimises for one scan: the observations that it gives, what is expected of a body, and where to stop.

At a state of the model a stage of the recipe asks for matches and makes terms of them (equations 7 to 9); the priors
(equations 4 and 5 and ours) and joints (equation 6) do not depend on the scan.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.core.stances import PRONE
from breastrig.correspondence.match import Correspondences, MatchRules, match
from breastrig.correspondence.target import ScanTarget
from breastrig.energies.body_prior import BodyPrior
from breastrig.energies.folding import Folding
from breastrig.energies.joint_limits import JointLimits
from breastrig.energies.joint_rest import JointRest
from breastrig.energies.landmarks import LandmarkObservation, Landmarks
from breastrig.energies.point_to_plane import PointToPlane
from breastrig.energies.point_to_point import PointToPoint
from breastrig.energies.scale_prior import ScalePrior
from breastrig.energies.shape_prior import ShapePrior
from breastrig.energies.symmetry import Symmetry
from breastrig.energies.table_contact import TableContact
from breastrig.fitting.body.expected_body import expected_body, expected_shapes
from breastrig.fitting.body.mirrored_landmarks import mirrored_landmarks
from breastrig.fitting.body.relief import observe_relief
from breastrig.fitting.observation_weights import observation_weights
from breastrig.fitting.recipe import Body, Hanging, Range, Scales, Shapes, Stage
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.least_squares.newton import Status, System, assemble, energy_of
from breastrig.least_squares.problem import ResidualTerm, inlier_chance, mixture_cost, outlier_cost
from breastrig.least_squares.quadratic_program import Bounds
from breastrig.rig.blocks import block
from breastrig.rig.cohort_posterior import Gaussian
from breastrig.rig.joints import Joints
from breastrig.rig.model import Rig
from breastrig.rig.parameters import BONE_DOFS, RigParameters
from breastrig.rig.skinning import pose
from breastrig.rig.stance_priors import in_stance, rest_turns
from breastrig.rig.state import BodyState

MIN_MATCHES = 30  # fewer cannot hold 136 unknowns, whatever the priors


def along(pair: Range, progress: float) -> float:
    """A range's value when the stage has tightened by `progress` (0 to 1)."""
    return float(pair[0] * (pair[1] / pair[0]) ** progress)


@dataclass(frozen=True, eq=False)
class Terms:
    """Residuals at a state, and what its observations cost beyond them: as the mixture's price of outliers has it."""

    residuals: list[ResidualTerm[BodyState]]
    picks: Landmarks | None
    beyond: float


class ScanProblem:
    """One scan's part of a fit."""

    def __init__(self, task: FitTask, *, partners: bool = True) -> None:
        """`partners`: whether a pick tells where its partner is; what judges picks lets none vouch for itself."""
        self.task = task
        joints = expected_joints(task)
        self.priors = prior_terms(task)
        self._limits = [] if (sigma := task.recipe.joints.limit_sigma) is None else [JointLimits(joints, sigma)]
        self._rest = JointRest(joints)
        self.scaling = step_scaling(task)
        self._picks = Landmarks(task.rig, tuple(task.given.values())) if task.given else None
        self.relief = task.relief
        self.partners: tuple[LandmarkObservation, ...] | None = None if partners else ()
        self._began = time.perf_counter()

    def start(self) -> BodyState:
        """The task's start, moved to where the recipe allows its shape weights."""
        return BodyState(self.task.rig, allowed_start(self.task))

    def matches(self, stage: Stage, progress: float, state: BodyState) -> Correspondences:
        """Of this stage's share of the model's vertices."""
        vertices, normals = state.vertices, state.normals
        rules = MatchRules(
            stage.method,
            along(stage.temperature, progress) * self.task.recipe.observed.farthest,
            stage.max_angle,
            reject_border=stage.reject_border,
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
        temperature, observed = along(stage.temperature, progress), self.task.recipe.observed
        data, beyond = data_term(self.task, stage, temperature, state, matches)
        picks = None if self._picks is None else self._counted(stage, temperature, state, self._picks)
        known = [*self.priors, data, *self._limits]
        followed = [] if picks is None else [picks]
        if stage.looks_at_form or self.task.stance == PRONE:  # a prone body is found by its breasts
            form, partners = self._seen(state, [*known, self._rest], picks)
            rig = self.task.rig
            followed += [Landmarks(rig, form, times=temperature * observed.form, name="form")] if form else []
            followed += [Landmarks(rig, partners, times=temperature, name="partners")] if partners else []
        return Terms([*known, *followed, self._rest], picks, beyond)

    def _counted(self, stage: Stage, temperature: float, state: BodyState, picks: Landmarks) -> Landmarks:
        """The picks at this temperature; far ones less where another place may have been meant."""
        now = replace(picks, times=temperature)
        if not stage.doubts_picks:
            return now
        chances = inlier_chance(now.deviations(state.vertices), now.outliers_from())
        return replace(now, weights=np.maximum(chances, 1e-6))

    def _seen(
        self, state: BodyState, others: list[ResidualTerm[BodyState]], picks: Landmarks | None
    ) -> tuple[Sequence[LandmarkObservation], Sequence[LandmarkObservation]]:
        """What the form shows, and what picks say of partners; looked for once, where a stage first asks."""
        if self.relief is None:
            self.relief = observe_relief(self.task, state)
        if self.partners is None:
            self.partners = ()
            if picks is not None:
                self.partners = mirrored_landmarks(
                    self.task, state, picks, lambda: assemble(others, state), self.scaling
                )
        return tuple(self.relief.values()), self.partners

    def system(self, terms: Terms, state: BodyState) -> System:
        """Gauss-Newton's quadratic model."""
        found = assemble(terms.residuals, state)
        return replace(found, energy=found.energy + terms.beyond)

    def energy(self, terms: Terms, state: BodyState) -> float:
        """What is to become small (equation 9)."""
        return energy_of(terms.residuals, state) + terms.beyond

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
        if self._picks is None or not self.task.picked:
            return None
        gaps = np.linalg.norm(self._picks.gaps(vertices), axis=1)
        return float(gaps[[each.name in self.task.picked for each in self._picks.observations]].mean())


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
    task: FitTask, stage: Stage, temperature: float, state: BodyState, matches: Correspondences
) -> tuple[ResidualTerm[BodyState], float]:
    """The scan's observations, and what they cost beyond the residuals: that some may be outliers, and that some are.

    Each is weighted by the skin that it stands for and by the chance that it belongs to the model.  With weights by
    skin it is the model's surface that is to lie on the scan, not its vertices: these are aimed at as far above the
    scan as the triangles around them lie below (observation_weights.py).
    """
    observed = task.recipe.observed
    all_counts = observation_weights(task.rig, task.recipe.observations, stage.every)
    counts, sigma = all_counts[matches.vertices], temperature * observed.skin
    off, even = matches.distances / sigma, observed.skin_outlier
    chances = inlier_chance(off, even)
    beyond = float(counts @ (mixture_cost(off, even) - 0.5 * chances * off**2))
    if even is not None:
        beyond += outlier_cost(even) * _beside_skin(task.target, state.vertices, matches, all_counts)
    if task.recipe.observations is not None:
        above = state.chordal_deviation[matches.vertices]
        matches = replace(matches, points=matches.points + above[:, None] * matches.normals)
    weights = counts * chances
    if stage.data_term == "point_to_projection":
        return PointToPoint(task.rig, projected(matches, state.vertices), weights, sigma), beyond
    if stage.along is not None:
        return PointToPoint(task.rig, matches, weights, stage.along * sigma, sigma), beyond
    return PointToPlane(task.rig, matches, weights, sigma), beyond


def _beside_skin(target: ScanTarget, vertices: Array, matches: Correspondences, counts: Array) -> float:
    """Sum of the counts of those of (V, 3) m vertices without a match that lie beside skin: not where the scan ends.

    What is not seen costs nothing: half a scan would else draw the body onto the half that it shows.
    """
    alone = counts > 0.0
    alone[matches.vertices] = False
    nearest = target.vertex_tree.query(vertices[alone])[1]
    return float(counts[alone] @ ~target.on_border[nearest])


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
    """What is expected of scales and shapes: by the statistics of bodies where the recipe and the rig have them.

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
