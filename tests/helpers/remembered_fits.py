"""Fits that this run has made before are not made again: the same job has the same events and the same files.

Fits are deterministic.  Tests of what is done with a fit (reports, transfers, the page) ask for the same few of them,
and each takes seconds of work.  What is remembered was fitted by the service's own function in its own process; files
lie beside the remembered uploads, where processes of all tests find them.  Events come after each other as they did
when the fit was made.  Tests of the fit itself do not use this.
"""

import hashlib
import json
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

from pydantic import TypeAdapter

from breastrig.core.assets import asset_folder
from breastrig.workflow.events import Event, FitEvent
from breastrig.workflow.jobs import FitJob
from helpers.remembered_uploads import FOLDER

Numbered = tuple[int, Event]  # of which of two jobs it is
EVENT: TypeAdapter[Event] = TypeAdapter(FitEvent)


def run_fit_once(job: FitJob) -> Iterator[Event]:
    """As `run_fit`."""
    from breastrig.workflow.run_fit import run_fit

    yield from (event for _, event in _once((job,), lambda jobs: ((0, each) for each in run_fit(jobs[0]))))


def run_pair_once(first: FitJob, second: FitJob) -> Iterator[Numbered]:
    """As `run_pair`."""
    from breastrig.workflow.run_pair import run_pair

    yield from _once((first, second), lambda jobs: run_pair(*jobs))


def _once(jobs: tuple[FitJob, ...], fit: Callable[[tuple[FitJob, ...]], Iterator[Numbered]]) -> Iterator[Numbered]:
    if FOLDER not in os.environ:
        yield from fit(jobs)
        return
    known = Path(os.environ[FOLDER], _key(jobs))
    if known.is_dir():
        yield from _again(jobs, known)
        return
    events = []
    for which, event in fit(jobs):
        events.append((which, event))
        if event.kind != "done":
            yield which, event
    _keep(jobs, events, known)  # before `done` is seen, for who sees it ends the task
    yield from ((which, event) for which, event in events if event.kind == "done")


def _again(jobs: tuple[FitJob, ...], known: Path) -> Iterator[Numbered]:
    """The events; the files are there before the first `done`."""
    began = time.perf_counter()
    for line in (known / "events").read_text("utf-8").splitlines():
        which, content = json.loads(line)
        event = EVENT.validate_python(content)
        if event.kind == "iterated":
            time.sleep(max(0.0, content["elapsed_s"] - (time.perf_counter() - began)))
        if event.kind == "done":
            shutil.copytree(known / str(which), jobs[which].out, dirs_exist_ok=True)
        yield which, event


def _key(jobs: tuple[FitJob, ...]) -> str:
    """Of everything that the fit depends on."""
    total = hashlib.sha256(b"fit")
    for job in jobs:
        total.update(repr(replace(job, scan=Path(), out=Path())).encode())
        model = job.model or asset_folder("model") / "torso.glb"
        for file in (model, model.with_suffix(".json"), job.scan):
            total.update(hashlib.sha256(file.read_bytes()).digest())
    return total.hexdigest()


def _keep(jobs: tuple[FitJob, ...], events: list[Numbered], known: Path) -> None:
    """Whole or not at all; others may be doing the same."""
    known.parent.mkdir(parents=True, exist_ok=True)
    place = Path(tempfile.mkdtemp(dir=known.parent))
    for which, job in enumerate(jobs):
        shutil.copytree(job.out, place / str(which))
    lines = [json.dumps([which, event.model_dump(mode="json")]) for which, event in events]
    (place / "events").write_text("\n".join(lines), "utf-8")
    try:
        place.rename(known)
    except OSError:
        shutil.rmtree(place)
