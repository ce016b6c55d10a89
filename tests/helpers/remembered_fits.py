"""Fits that this run has made before are not made again: the same job has the same events and the same files.

For tests of what is done with a fit (reports, transfers); see remembered.py.  What is remembered was fitted by the
service's own function in its own process.  For the browser events come after each other as they did when the fit was
made.  Tests of the fit itself do not use this.
"""

import os
import time
from collections.abc import Iterator

from pydantic import TypeAdapter

from breastrig.use.steps.events import Event, FitEvent
from breastrig.use.steps.settings import FitJob
from helpers.remembered import FOLDER, keep, kept, key_of_job

EVENT: TypeAdapter[Event] = TypeAdapter(FitEvent)
PACED = "BREASTRIG_E2E_EXAMPLES" in os.environ


def run_fit_once(job: FitJob) -> Iterator[Event]:
    """As `run_fit`."""
    from breastrig.use.fit import run_fit

    if FOLDER not in os.environ:
        yield from run_fit(job)
        return
    key = key_of_job("fit", job)
    if (known := kept(key)) is not None:
        yield from _again(job, *known[0])
        return
    events = []
    for event in run_fit(job):
        events.append(event)
        if event.kind == "done":  # kept before it is seen, for who sees it ends the task
            files = {file.name: file.read_bytes() for file in job.out.iterdir()}
            keep(key, ([each.model_dump_json() for each in events], files))
        yield event


def _again(job: FitJob, events: list[str], files: dict[str, bytes]) -> Iterator[Event]:
    """The events; the files are there before `done`."""
    began = time.perf_counter()
    for event in map(EVENT.validate_json, events):
        if event.kind == "iterated" and PACED:
            time.sleep(max(0.0, event.elapsed_s - (time.perf_counter() - began)))
        if event.kind == "done":
            for name, content in files.items():
                (job.out / name).write_bytes(content)
        yield event
