"""Two stances of one patient as a stream: of recorded iterates in memory, and from files to files as events.

Whoever stops consuming a generator cancels both.
"""

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from breastrig.core.errors import BadScan, BadSettings
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.files.result import ResultFile
from breastrig.fitting.picks.checked_fit import agreeing_picks
from breastrig.fitting.two_stances import ALIKE, ONE_BODY, Coupling, body_shapes, fit_pair_iterates
from breastrig.rig.model import Rig
from breastrig.scan.scan import Scan
from breastrig.workflow.events import Done, Event
from breastrig.workflow.fit_recorder import FitOutcome, FitRecorder, RecordedIterate
from breastrig.workflow.folder.fit_files import write_fit_files
from breastrig.workflow.jobs import FitJob
from breastrig.workflow.scan_fit import (
    Clock,
    FitPlan,
    ReadyScan,
    fit_plan,
    prepare_fit,
    read_model,
    scan_of_job,
)

PAIR_SCHEMA = "breastrig/pair@1"


@dataclass(frozen=True, eq=False)
class PairOutcome:
    """What is known of both stances at the end."""

    first: FitOutcome
    second: FitOutcome


def prepare_pair(plans: tuple[FitPlan, FitPlan], scans: Sequence[tuple[Scan, float]]) -> tuple[ReadyScan, ReadyScan]:
    """Two scans, each with the seconds that reading it took, made ready; BadScan when they are one and the same."""
    (scan, read_s), (other, other_read_s) = scans
    if scan.sha256 == other.sha256:
        raise BadScan("Both scans are the same file; give a scan of the same patient in another stance.")
    return prepare_fit(plans[0], scan, read_s), prepare_fit(plans[1], other, other_read_s)


def pair_steps(
    ready: tuple[ReadyScan, ReadyScan], coupling: Coupling, clock: Clock
) -> Iterator[tuple[RecordedIterate, RecordedIterate] | PairOutcome]:
    """Every iterate of both stances, then their outcome; FitFailed when there is none.  `clock` began with the fit."""
    recorders = FitRecorder(ready[0]), FitRecorder(ready[1])
    clock.lap()
    solve = sum(each.timing_s["solve"] for each in ready)
    (task, rejected), (other_task, other_rejected) = (agreeing_picks(each.task, each.known_iterates) for each in ready)
    iterates = fit_pair_iterates(task, other_task, coupling)
    while True:
        iterate = next(iterates, None)
        solve += clock.lap()
        if iterate is None:
            break
        yield (
            recorders[0].record(replace(iterate.first, not_followed=rejected)),
            recorders[1].record(replace(iterate.second, not_followed=other_rejected)),
        )
        clock.lap()
    yield PairOutcome(recorders[0].finish(solve, clock), recorders[1].finish(solve, clock))


def run_pair(first: FitJob, second: FitJob, coupling: Coupling = ALIKE) -> Generator[tuple[int, Event], None, None]:
    """(0 or 1 for the stance, its event): each stance's Started, Iterated …, Done; a BreastRigError ends both.

    Each stance leaves the files of a fit in its own job's folder before its Done.
    """
    if first.model != second.model:
        raise BadSettings("Two stances are fitted together with one model; give the same model for both.")
    clock = Clock()
    rig = read_model(first)
    plans = fit_plan(first, rig, first.landmarks_mm), fit_plan(second, rig, second.landmarks_mm)
    ready = prepare_pair(plans, [scan_of_job(job) for job in (first, second)])
    for which, each in enumerate(ready):
        yield which, each.started
    for step in pair_steps(ready, coupling, clock):
        if isinstance(step, PairOutcome):
            results = write_fit_files(step.first, first.out), write_fit_files(step.second, second.out)
            yield from enumerate(Done(result=result) for result in results)
        else:
            yield from enumerate(each.event for each in step)


def shared_body(rig: Rig, result: ResultFile) -> dict[str, Any]:
    """What both stances have in common, as result.json has it: the bones' scales and the body's shapes."""
    shared = body_shapes(rig)
    shapes = zip(rig.shape_names, shared, strict=True)
    return {
        "bone_scales": {bone.name: bone.scale for bone in result.parameters.bones},
        "blendshapes": {name: result.parameters.blendshapes[name] for name, is_shared in shapes if is_shared},
    }


def pair_document(rig: Rig, results: Sequence[ResultFile], places: Sequence[str], coupling: Coupling) -> dict[str, Any]:
    """The document breastrig/pair@1 of two result.json's, which are found at `places`."""
    first, second = results
    return {
        "schema": PAIR_SCHEMA,
        "notice": LIMITS_OF_USE,
        "results": dict(zip(("first", "second"), places, strict=True)),
        "stances": [first.stance, second.stance],
        "bodies": "one" if coupling == ONE_BODY else "alike",
        "shared": shared_body(rig, first) if coupling == ONE_BODY else None,
        "converged": first.converged,
        "stop_reason": first.stop_reason,
        "iterations": first.iterations,
        "timing_s": {"solve": second.timing_s["solve"], "total": second.timing_s["total"]},
    }
