"""Picks that cannot be right: found before the fit among themselves, during and after it by the fitted model.

Before: when the picks as a whole only make sense with left and right exchanged, none is used
(`sides_exchanged`); one on the wrong place does not turn the start, which trusts the majority (orientation.py).
During: the landmark term's robust kernel weakens what stays far (presets, `landmark_kernel_scale`).
After: a single wrong pick is followed where the skin around it is smooth, so its own distance to the fitted model says
little.  So every pick is asked how far it would be had it not been given.  With the normal equations H of the fitted
state, the rows J_i of pick i (in standard deviations) and its residual r_i, leaving it out gives to first order the
residual

    (I − J_i H⁻¹ J_iᵀ)⁻¹ r_i

(the PRESS residual; Allen, The relationship between variable selection and data augmentation, 1974).  Of those beyond
their limit the one without which the others agree best is dropped, and the fit goes on from where it stands, until all
remaining picks agree with each other.  On the dev scans true picks reach 15 mm (the navel 36 mm, where the belly has no
form); of 117 picks 50 mm off the least, navels apart, has 32 mm, where its own distance to the model can be 2 mm.
What the fitted model is still far from is named, with "exchanged" where the partner's place would fit.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from breastrig.core.arrays import Array
from breastrig.energies.landmarks import Landmarks
from breastrig.fitting.fit import fit_iterates
from breastrig.fitting.orientation import MIN_LANDMARKS, trusted_similarity
from breastrig.fitting.problem import ScanProblem
from breastrig.fitting.recipe import Outliers
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.least_squares.newton import Status
from breastrig.least_squares.problem import HARD
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.state import BodyState

FLOOR = 1e-6  # of an unknown's natural size: keeps directions that nothing holds out of the inverse


@dataclass(frozen=True)
class Doubt:
    """A pick that is asked about, and why, as a sentence."""

    names: tuple[str, ...]
    reason: str
    followed: bool = False  # True: unusual, but followed all the same


def partner(rig: Rig, name: str) -> str:
    """The landmark on the other side."""
    return next(landmark.mirror for landmark in rig.landmarks if landmark.name == name)


def sides_exchanged(rig: Rig, landmarks: dict[str, Array], outliers: Outliers) -> bool:
    """Whether the picks ((3,) m by name) as a whole make sense only with left and right exchanged."""
    names = tuple(landmarks)
    if sum(partner(rig, name) != name for name in names) < 4:
        return False
    picked = np.array([landmarks[name] for name in names])
    misfit = []
    for order in (names, tuple(partner(rig, name) for name in names)):
        model = rig.landmark_points(order).positions(rig.template, rig.faces)
        misfit.append(float(np.median(trusted_similarity(model, picked)[1])))
    return misfit[1] < outliers.exchanged_gain * misfit[0]


class LeaveOneOut:
    """The picks of a task whose fit ended at `x`, each seen as if it had not been given."""

    def __init__(self, task: FitTask, x: RigParameters) -> None:
        problem, stage, state = ScanProblem(task), task.recipe.stages[-1], BodyState(task.rig, x)
        terms = problem.terms(stage, 1.0, state, problem.matches(stage, 1.0, state))
        picks = next(term for term in terms if isinstance(term, Landmarks))
        system = problem.system(terms, state)
        held = system.constraint_jacobian
        hessian = system.hessian + held.T @ (held / np.maximum(system.compliance, HARD)[:, None])
        lin = picks.linearise(state)
        self.names = tuple(task.landmarks)
        count = len(self.names)
        rows = lin.jacobian.reshape(3, count, -1).transpose(1, 0, 2).reshape(3 * count, -1)
        self._residual = lin.residual.reshape(3, count).T  # (L, 3)
        self._sigma = picks.sigma
        self._hat = rows @ np.linalg.solve(hessian + np.diag(FLOOR * problem.scaling), rows.T)  # (3L, 3L)

    @property
    def distances(self) -> dict[str, float]:
        """Name -> m from the fitted model's landmark to the pick, as it was given."""
        return dict(zip(self.names, map(float, np.linalg.norm(self._residual, axis=1) * self._sigma), strict=True))

    def gaps(self, without: Collection[str] = ()) -> dict[str, float]:
        """Name -> m for every pick, each left out alone, those in `without` left out all the time."""
        hat, residual = self._hat, self._residual.ravel()
        gone = np.repeat([name in without for name in self.names], 3)
        if gone.any():  # Woodbury: the rows of the picks that are gone leave the normal equations
            push = np.linalg.solve(np.eye(int(gone.sum())) - hat[np.ix_(gone, gone)], np.eye(int(gone.sum())))
            residual = residual + hat[:, gone] @ push @ residual[gone]
            hat = hat + hat[:, gone] @ push @ hat[gone]
        result: dict[str, float] = {}
        for i, name in enumerate(self.names):
            own = slice(3 * i, 3 * i + 3)
            error: Array = residual[own]
            if name not in without:
                error = np.asarray(np.linalg.solve(np.eye(3) - hat[own, own], error))
            result[name] = float(np.linalg.norm(error) * self._sigma[i])
        return result


def contradicted(task: FitTask, x: RigParameters) -> str | None:
    """The pick that the model fitted at `x` and all other picks contradict; None when all agree."""
    if not task.landmarks:
        return None
    picks = LeaveOneOut(task, x)
    recipe, rules = task.recipe, task.recipe.outliers
    limit = {name: recipe.outlier_limit(name) + task.landmark_errors.get(name, 0.0) for name in picks.names}
    gaps = picks.gaps()
    open_to_doubt = [name for name in picks.names if name not in task.certain]
    suspects = [name for name in open_to_doubt if gaps[name] > limit[name]]
    if not suspects and max(picks.distances.values()) > rules.doubtful:  # it, or a neighbour of it, is wrong
        suspects = [name for name in open_to_doubt if gaps[name] > rules.neighbour * limit[name]]

    def disagreement(suspect: str) -> float:
        gaps = picks.gaps(without=(suspect,))
        return sum((gap / limit[name]) ** 2 for name, gap in gaps.items() if name != suspect)

    return min(suspects, key=disagreement, default=None)


def checked_iterates(task: FitTask, begun: Sequence[FitIterate] = ()) -> Iterator[FitIterate]:
    """As fit_iterates; iterates after a pick was dropped name it in `not_followed`.

    `begun` are all iterates of fit_iterates(task) where they are known already: the fit goes on from there.
    """
    dropped: tuple[str, ...] = ()
    most = min(int(task.recipe.outliers.most * len(task.landmarks)), len(task.landmarks) - MIN_LANDMARKS)
    iteration, elapsed = 0, 0.0
    while True:
        for iterate in begun or fit_iterates(task):
            numbered = replace(
                iterate,
                iteration=iteration + iterate.iteration,
                elapsed_s=elapsed + iterate.elapsed_s,
                not_followed=dropped,
            )
            if iterate.status is Status.RUNNING and (iterate.iteration > 0 or not dropped):
                yield numbered
        sound = iterate.status in (Status.CONVERGED, Status.OUT_OF_ITERATIONS, Status.STALLED)
        name = contradicted(task, iterate.parameters) if sound and len(dropped) < most else None
        if name is None:
            yield numbered
            return
        yield replace(numbered, status=Status.RUNNING)
        dropped, begun = (*dropped, name), ()
        iteration, elapsed = numbered.iteration, numbered.elapsed_s
        remaining = {other: place for other, place in task.landmarks.items() if other != name}
        task = replace(task, start=iterate.parameters, landmarks=remaining)


def agreeing_picks(task: FitTask, begun: Sequence[FitIterate] = ()) -> tuple[FitTask, tuple[str, ...]]:
    """The task without the picks that all else contradicts, and their names, found by a fit of its own (or `begun`)."""
    if not task.landmarks:
        return task, ()
    *_, last = checked_iterates(task, begun)
    kept = {name: place for name, place in task.landmarks.items() if name not in last.not_followed}
    return replace(task, landmarks=kept), last.not_followed


def doubts(
    rig: Rig, outliers: Outliers, fitted: dict[str, Array], picked: dict[str, Array], dropped: Collection[str] = ()
) -> tuple[Doubt, ...]:
    """What the fitted model's landmarks ((3,) m by name) say of the picks; those that the fit dropped are named."""
    gaps = {name: float(np.linalg.norm(fitted[name] - place)) for name, place in picked.items()}
    far = [name for name in picked if name in dropped or gaps[name] > outliers.doubtful]
    result, named = [], set()
    for name in far:
        other = partner(rig, name)
        pair = (name, other)
        if name in named:
            continue
        if (
            other != name
            and other in far
            and all(np.linalg.norm(fitted[a] - picked[b]) < outliers.near_partner for a, b in (pair, pair[::-1]))
        ):
            named |= set(pair)
            result.append(Doubt(pair, f"{name} and {other} look exchanged; they were not followed."))
            continue
        result.append(
            Doubt((name,), f"{name} is {1e3 * gaps[name]:.0f} mm from where the model puts it; it was not followed.")
        )
    return tuple(result)
