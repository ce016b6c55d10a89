"""The registration: match, build the terms, one damped Gauss-Newton step, yield; stage after stage.

A generator of frozen iterates is the only way to run a fit: the command line, the service and the tests all
consume it, and whoever stops consuming cancels the fit.  Nothing here prints, stores or draws.

At a state of the model a stage of the recipe computes matches and makes terms of them (equations 7 to 9); the priors
(equations 4 and 5 and ours) and joints (equation 6) do not depend on the scan.
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans
from breastrig.core.stances import PRONE
from breastrig.correspondence.match import Correspondences, MatchRules, match
from breastrig.correspondence.target import ScanTarget
from breastrig.energies.joint_limits import JointLimits
from breastrig.energies.joint_rest import JointRest
from breastrig.energies.landmarks import LandmarkObservation, Landmarks
from breastrig.energies.modes import Modes
from breastrig.energies.point_to_plane import PointToPlane
from breastrig.energies.point_to_point import PointToPoint
from breastrig.fitting.body.expected_body import allowed_start, expected_joints, prior_terms, step_bounds, step_scaling
from breastrig.fitting.body.landmarks import mirrored_landmarks, observe_relief
from breastrig.fitting.recipe import Observations, Range, Stage, Stop
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.geometry.normals import face_areas
from breastrig.least_squares.newton import Status, System, assemble, damped_step, energy_of
from breastrig.least_squares.problem import ResidualTerm, inlier_chance, mixture_cost, outlier_cost
from breastrig.least_squares.quadratic_program import Bounds
from breastrig.rig.blocks import block, shape_block
from breastrig.rig.model import Rig
from breastrig.rig.modes import mode_count, mode_sizes
from breastrig.rig.parameters import BONE_DOFS
from breastrig.rig.state import BodyState


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
        self._modes = None if (sizes := mode_sizes(task.rig)) is None else Modes(task.rig, sizes.symmetry)
        self.scaling = step_scaling(task)
        self._picks = Landmarks(task.rig, tuple(task.given.values())) if task.given else None
        self.relief = task.relief
        self.partners: tuple[LandmarkObservation, ...] | None = None if partners else ()
        self._began = time.perf_counter()

    def start(self) -> BodyState:
        """The task's start, moved to where the recipe allows its shape weights."""
        return BodyState(self.task.rig, allowed_start(self.task))

    def matches(self, stage: Stage, progress: float, state: BodyState) -> Correspondences:
        """The matches of this stage's share of the model's vertices."""
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
        """Whether neither skin nor landmarks hold the model."""
        return len(matches.distances) < MIN_MATCHES and self._picks is None

    def terms(self, stage: Stage, progress: float, state: BodyState, matches: Correspondences) -> Terms:
        """All residuals at a state; those of scan and landmarks are made for it."""
        temperature, observed = along(stage.temperature, progress), self.task.recipe.observed
        data, beyond = data_term(self.task, stage, temperature, state, matches)
        picks = None if self._picks is None else self._counted(stage, temperature, state, self._picks)
        known = [*self.priors, data, *self._limits]
        if self._modes is not None and len(state.x.modes):
            known.append(self._modes)
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
        """Observations from the relief, and of the picks' partners; computed once, at a stage's first request."""
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
        """The objective (equation 9)."""
        return energy_of(terms.residuals, state) + terms.beyond

    def with_its_modes(self, stage: Stage, state: BodyState) -> BodyState:
        """The state, with modes where the stage is the first to move them."""
        if self._modes is None or not stage.free_modes or len(state.x.modes):
            return state
        return BodyState(state.rig, replace(state.x, modes=np.zeros(mode_count(state.rig))))

    def free(self, stage: Stage, unknowns: int) -> Booleans:
        """(P,) which of so many unknowns the stage moves."""
        rig = self.task.rig
        bones = len(rig.bones)
        free = np.full(unknowns, stage.free_modes, dtype=np.bool_)
        free[: BONE_DOFS * bones] = True
        free[: BONE_DOFS * bones].reshape(bones, BONE_DOFS)[:, 6:9] = stage.free_scales
        free[shape_block(rig)] = [shape.kind in stage.free_shapes for shape in rig.shapes]
        for name in self.task.locked:
            free[block(rig, name)] = False
        return free

    def bounds(self, state: BodyState) -> Bounds:
        """Room left for the scales and the shape weights."""
        return step_bounds(self.task, state.x)

    def iterate(
        self, iteration: int, stage: Stage, state: BodyState, energy: float, matches: Correspondences, status: Status
    ) -> FitIterate:
        """A state as an iterate."""
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
    scan as the triangles around them lie below.
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


__all__ = ["FitIterate", "FitTask", "fit_iterates"]


class _Stillness:
    """Counts the iterations in a row in which the mean distance hardly changed.

    Some fits end in a cycle of two: a few vertices at a border find another partner at every other step.  That the
    distance is what it was two steps ago counts as well, for nothing more comes of it.
    """

    def __init__(self, stop: Stop) -> None:
        self._stop, self._previous, self._earlier, self._quiet = stop, np.inf, np.inf, 0

    def new_stage(self) -> None:
        self._quiet, self._previous, self._earlier = 0, np.inf, np.inf

    def reached(self, mean: float, progress: float) -> bool:
        """Whether the fit may end at this mean distance (m); only a stage that has tightened can be still."""
        change = min(abs(mean - self._previous), abs(mean - self._earlier))
        self._quiet = self._quiet + 1 if progress == 1.0 and change < self._stop.distance_change_m else 0
        self._previous, self._earlier = mean, self._previous
        return self._quiet >= self._stop.patience


def stage_progress(stage: Stage, step: int) -> float:
    """Share by which the stage has tightened before step number `step`: 0 to 1."""
    return min(step / max(stage.tighten - 1, 1), 1.0)


@dataclass(frozen=True, eq=False)
class InitialPoint:
    """The initial point of stages: the start, or the end of earlier stages."""

    point: BodyState
    energy: float = np.nan
    number: int = 0


def iterates(
    problem: ScanProblem, stages: Sequence[Stage] | None = None, initial: InitialPoint | None = None
) -> Iterator[FitIterate]:
    """First the start as iteration 0, then one iterate a step; the last status says why it stopped.

    Of `stages` only, where they are given, from `initial`.
    """
    recipe = problem.task.recipe
    stillness = _Stillness(recipe.stop)
    first = InitialPoint(problem.start()) if initial is None else initial
    point, energy, number = first.point, first.energy, first.number
    done = recipe.stages[-1]
    for stage in recipe.stages if stages is None else stages:
        done = stage
        point = problem.with_its_modes(stage, point)
        free, last_stage, damping = problem.free(stage, point.dof), stage is recipe.stages[-1], recipe.damping
        stillness.new_stage()
        for step_number in range(stage.iterations):
            progress = stage_progress(stage, step_number)
            matches = problem.matches(stage, progress, point)
            now = problem.iterate(number, stage, point, energy, matches, Status.RUNNING)
            is_still = stillness.reached(mean_distance(matches, np.inf), progress)
            if last_stage and is_still:
                yield replace(now, status=Status.CONVERGED)
                return
            if problem.lost(matches):
                yield replace(now, status=Status.STALLED)
                return
            yield now
            terms = problem.terms(stage, progress, point, matches)
            step = damped_step(
                problem.system(terms, point),
                partial(problem.energy, terms),
                point,
                scaling=problem.scaling[: point.dof],
                damping=damping,
                least_damping=recipe.damping,
                bounds=problem.bounds(point),
                free=free,
            )
            if step.status is Status.NOT_FINITE:
                yield problem.iterate(number, stage, point, energy, matches, Status.NOT_FINITE)
                return
            point, energy, damping = step.x, step.energy, step.damping
            number += 1
            if step.status is Status.STALLED and last_stage:
                yield problem.iterate(number, stage, point, energy, matches, Status.STALLED)
                return
    matches = problem.matches(done, 1.0, point)
    yield problem.iterate(number, done, point, energy, matches, Status.OUT_OF_ITERATIONS)


def fit_iterates(task: FitTask) -> Iterator[FitIterate]:
    """Yields the start as iteration 0, then one iterate a step; the last one's status says why it stopped."""
    return iterates(ScanProblem(task))
