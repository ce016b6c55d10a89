"""Fits that this run has made before are not made again: the same job has the same events and the same files.

Fits are deterministic.  Tests of what is done with a fit (reports, transfers) ask for the same few of them, and each
takes seconds of work.  What is remembered was fitted by the service's own function in its own process; files lie
beside the remembered uploads, where processes of all tests find them.  Events come after each other as they did when
the fit was made.  Tests of the fit itself do not use this.
"""

import hashlib
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from pydantic import TypeAdapter

from breastrig.core.assets import asset_folder
from breastrig.use.steps.events import Event, FitEvent
from breastrig.use.steps.settings import FitJob
from helpers.remembered_uploads import FOLDER

EVENT: TypeAdapter[Event] = TypeAdapter(FitEvent)


def run_fit_once(job: FitJob) -> Iterator[Event]:
    """As `run_fit`."""
    from breastrig.use.fit import run_fit

    if FOLDER not in os.environ:
        yield from run_fit(job)
        return
    known = Path(os.environ[FOLDER], _key(job))
    if known.is_dir():
        yield from _again(job, known)
        return
    events = []
    for event in run_fit(job):
        events.append(event)
        if event.kind != "done":
            yield event
    _keep(job, events, known)  # before `done` is seen, for who sees it ends the task
    yield from (event for event in events if event.kind == "done")


def _again(job: FitJob, known: Path) -> Iterator[Event]:
    """The events; the files are there before `done`."""
    began = time.perf_counter()
    for line in (known / "events").read_text("utf-8").splitlines():
        event = EVENT.validate_json(line)
        if event.kind == "iterated":
            time.sleep(max(0.0, event.elapsed_s - (time.perf_counter() - began)))
        if event.kind == "done":
            shutil.copytree(known / "files", job.out, dirs_exist_ok=True)
        yield event


def _key(job: FitJob) -> str:
    """Of everything that the fit depends on."""
    total = hashlib.sha256(b"fit")
    total.update(repr(replace(job, scan=Path(), out=Path())).encode())
    model = job.model or asset_folder("model") / "torso.glb"
    for file in (model, model.with_suffix(".json"), job.scan):
        total.update(hashlib.sha256(file.read_bytes()).digest())
    return total.hexdigest()


def _keep(job: FitJob, events: list[Event], known: Path) -> None:
    """Whole or not at all; others may be doing the same."""
    known.parent.mkdir(parents=True, exist_ok=True)
    place = Path(tempfile.mkdtemp(dir=known.parent))
    shutil.copytree(job.out, place / "files")
    (place / "events").write_text("\n".join(event.model_dump_json() for event in events), "utf-8")
    try:
        place.rename(known)
    except OSError:
        shutil.rmtree(place)
