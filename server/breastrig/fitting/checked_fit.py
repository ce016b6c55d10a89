"""A fit that does not follow a pick which all else contradicts.

After the fit every pick is asked how far it would be had it not been given (left_out.py).  Of those beyond their
limit the one without which the others agree best is let go, and the fit goes on from where it stands, until all
remaining picks agree with each other.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from breastrig.fitting.fit import fit_iterates
from breastrig.fitting.landmark_check import DOUBTFUL, MIN_LANDMARKS
from breastrig.fitting.left_out import LeftOut
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.least_squares.newton import Status
from breastrig.rig.parameters import RigParameters

# m; true picks of the dev scans, clicked 5 mm off, reach 24 mm, and on smooth skin as far as said below; those
# 50 mm off start at 28 mm, navels apart, which the model cannot place on a belly without form
LIMIT = 0.026
LIMIT_ON_SMOOTH_SKIN = {"midclavicle": 0.03, "umbilicus": 0.046}
NEIGHBOUR = 0.6  # of the limit: a wrong pick that is followed pushes its neighbour away instead
MOST = 1.0 / 3.0  # of the picks may be let go: beyond it nobody knows who is right


def contradicted(task: FitTask, x: RigParameters) -> str | None:
    """The pick that the model fitted at `x` and all other picks contradict; None when all agree."""
    if not task.landmarks:
        return None
    picks = LeftOut(task, x)
    limit = {
        name: LIMIT_ON_SMOOTH_SKIN.get(name.removesuffix("_L").removesuffix("_R"), LIMIT)
        + task.landmark_errors.get(name, 0.0)
        for name in picks.names
    }
    gaps = picks.gaps()
    suspects = [name for name in picks.names if gaps[name] > limit[name]]
    if not suspects and max(picks.distances.values()) > DOUBTFUL:  # one is far already: it, or a neighbour, is wrong
        suspects = [name for name in picks.names if gaps[name] > NEIGHBOUR * limit[name]]

    def disagreement(suspect: str) -> float:
        gaps = picks.gaps(without=(suspect,))
        return sum((gap / limit[name]) ** 2 for name, gap in gaps.items() if name != suspect)

    return min(suspects, key=disagreement, default=None)


def checked_iterates(task: FitTask, begun: Sequence[FitIterate] = ()) -> Iterator[FitIterate]:
    """As fit_iterates; iterates after a pick was let go name it in `not_followed`.

    `begun` are all iterates of fit_iterates(task) where they are known already: the fit goes on from there.
    """
    let_go: tuple[str, ...] = ()
    most = min(int(MOST * len(task.landmarks)), len(task.landmarks) - MIN_LANDMARKS)
    iteration, elapsed = 0, 0.0
    while True:
        for iterate in begun or fit_iterates(task):
            told = replace(
                iterate,
                iteration=iteration + iterate.iteration,
                elapsed_s=elapsed + iterate.elapsed_s,
                not_followed=let_go,
            )
            if iterate.status is Status.RUNNING and (iterate.iteration > 0 or not let_go):
                yield told
        sound = iterate.status in (Status.CONVERGED, Status.OUT_OF_ITERATIONS, Status.STALLED)
        name = contradicted(task, iterate.parameters) if sound and len(let_go) < most else None
        if name is None:
            yield told
            return
        yield replace(told, status=Status.RUNNING)
        let_go, begun = (*let_go, name), ()
        iteration, elapsed = told.iteration, told.elapsed_s
        remaining = {other: place for other, place in task.landmarks.items() if other != name}
        task = replace(task, start=iterate.parameters, landmarks=remaining)


def agreeing_picks(task: FitTask, begun: Sequence[FitIterate] = ()) -> tuple[FitTask, tuple[str, ...]]:
    """The task without the picks that all else contradicts, and their names, found by a fit of its own (or `begun`)."""
    if not task.landmarks:
        return task, ()
    *_, last = checked_iterates(task, begun)
    kept = {name: place for name, place in task.landmarks.items() if name not in last.not_followed}
    return replace(task, landmarks=kept), last.not_followed
