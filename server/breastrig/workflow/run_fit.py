"""One fit from files to files, as a stream of events: what the command line and the service both run.

Whoever stops consuming the generator cancels the fit; nothing is written then but what was already there.
"""

from collections.abc import Iterator

from breastrig.fitting.landmark_outliers import checked_iterates
from breastrig.workflow.events import Event
from breastrig.workflow.scan_fit import STANCES, Clock, FitJob, ScanStory, made_ready, read_model

__all__ = ["STANCES", "FitJob", "run_fit"]


def run_fit(job: FitJob) -> Iterator[Event]:
    """Started, Iterated …, Done; a BreastRigError instead when it cannot be done.

    Writes result.json, scan.ply, fitted.ply, fitted.glb, drawing.json, distances.bin and fit.log.jsonl into job.out
    before Done.
    """
    clock = Clock()
    ready = made_ready(job, read_model(job))
    story = ScanStory(ready)
    yield ready.started
    clock.lap()
    solve = ready.timing_s["solve"]
    steps = checked_iterates(ready.task, ready.begun)
    while True:
        iterate = next(steps, None)
        solve += clock.lap()
        if iterate is None:
            break
        yield story.told(iterate)
        clock.lap()
    yield story.finished(solve, clock)
