"""One fit as a stream: of recorded iterates in memory, and from files to files as events.

The command line, the service and a program's `import breastrig` consume the same iterates.  Whoever stops consuming
a generator cancels the fit; nothing is written then but what was already there.
"""

from collections.abc import Generator, Iterator

from breastrig.fitting.solve import checked_iterates
from breastrig.use.folder.fit_files import write_fit_files
from breastrig.use.jobs import FitJob
from breastrig.use.steps.events import Done, Event
from breastrig.use.steps.prepare import (
    Clock,
    ReadyScan,
    fit_plan,
    prepare_fit,
    read_model,
    scan_of_job,
)
from breastrig.use.steps.recorder import FitOutcome, RecordedIterate, outcome_of, record


def fit_steps(ready: ReadyScan, clock: Clock) -> Iterator[RecordedIterate | FitOutcome]:
    """Every iterate of the fit, then its outcome; FitFailed when there is none.  `clock` began with the fit."""
    clock.lap()
    solve, recorded = ready.timing_s["solve"], list[RecordedIterate]()
    iterates = iter(ready.known_iterates) if ready.known_iterates else checked_iterates(ready.task)
    while True:
        iterate = next(iterates, None)
        solve += clock.lap()
        if iterate is None:
            break
        recorded.append(record(ready, iterate))
        yield recorded[-1]
        clock.lap()
    yield outcome_of(ready, recorded, solve, clock)


def run_fit(job: FitJob) -> Generator[Event, None, None]:
    """Started, Iterated …, Done; a BreastRigError instead when it cannot be done.

    Writes all FIT_FILES (files/result.py) into job.out before Done.
    """
    clock = Clock()
    plan = fit_plan(job, read_model(job), job.landmarks_mm)
    ready = prepare_fit(plan, *scan_of_job(job))
    yield ready.started
    for step in fit_steps(ready, clock):
        if isinstance(step, FitOutcome):
            yield Done(result=write_fit_files(step, job.out))
        else:
            yield step.event
