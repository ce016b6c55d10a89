"""Two stances of one patient, from files to files, as two streams of events that go hand in hand.

Whoever stops consuming the generator cancels both.
"""

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from breastrig.core.errors import BadInput, BadScan, BadSettings
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.private_files import write_private
from breastrig.fitting.landmark_outliers import agreeing_picks
from breastrig.fitting.two_stances import ONE_BODY, Coupling, SharedBody, fit_pair_iterates
from breastrig.rig.model import Rig
from breastrig.workflow.events import Done, Event
from breastrig.workflow.fit_files import json_bytes
from breastrig.workflow.scan_fit import Clock, FitJob, ScanStory, made_ready, read_model

PAIR_SCHEMA = "breastrig/pair@1"


def run_pair(
    first: FitJob, second: FitJob, pair_file: Path | None = None, coupling: Coupling = ONE_BODY
) -> Iterator[tuple[int, Event]]:
    """(0 or 1 for the stance, its event): each stance's Started, Iterated …, Done; a BreastRigError ends both.

    Each stance leaves the seven files of a fit in its own job's folder before its Done; pair_file (breastrig/pair@1),
    when given, says what the two have in common.
    """
    if first.model != second.model:
        raise BadSettings("Two stances are fitted together with one model; give the same model for both.")
    clock = Clock()
    rig = read_model(first)
    ready = made_ready(first, rig), made_ready(second, rig)
    if ready[0].scan.sha256 == ready[1].scan.sha256:
        raise BadScan("Both scans are the same file; give a scan of the same patient in another stance.")
    stories = ScanStory(ready[0]), ScanStory(ready[1])
    for which, each in enumerate(ready):
        yield which, each.started
    clock.lap()
    solve = sum(each.timing_s["solve"] for each in ready)
    (task, let_go), (other_task, other_let_go) = (agreeing_picks(each.task, each.begun) for each in ready)
    steps = fit_pair_iterates(task, other_task, coupling)
    while True:
        iterate = next(steps, None)
        solve += clock.lap()
        if iterate is None:
            break
        told = (
            stories[0].told(replace(iterate.first, not_followed=let_go)),
            stories[1].told(replace(iterate.second, not_followed=other_let_go)),
        )
        yield 0, told[0]
        yield 1, told[1]
        clock.lap()
    done = stories[0].finished(solve, clock), stories[1].finished(solve, clock)
    if pair_file is not None:
        _write_pair_file(pair_file, rig, (first, second), done, coupling)
    yield 0, done[0]
    yield 1, done[1]


def shared_body(rig: Rig, result: dict[str, Any]) -> dict[str, Any]:
    """What both stances have in common, as result.json has it: the bones' scales and the body's shapes."""
    shared = SharedBody(rig).body_shapes
    parameters = result["parameters"]
    return {
        "bone_scales": {bone["name"]: bone["scale"] for bone in parameters["bones"]},
        "blendshapes": {
            name: parameters["blendshapes"][name]
            for name, is_shared in zip(rig.shape_names, shared, strict=True)
            if is_shared
        },
    }


def _write_pair_file(
    file: Path, rig: Rig, jobs: tuple[FitJob, FitJob], done: tuple[Done, Done], coupling: Coupling
) -> None:
    results: list[dict[str, Any]] = [each.result for each in done]
    document = {
        "schema": PAIR_SCHEMA,
        "notice": LIMITS_OF_USE,
        "results": {
            name: os.path.relpath(job.out / "result.json", file.parent)
            for name, job in zip(("first", "second"), jobs, strict=True)
        },
        "stances": [result["stance"] for result in results],
        "bodies": "one" if coupling.exact else "alike",
        "shared": shared_body(rig, results[0]) if coupling.exact else None,
        "converged": results[0]["converged"],
        "stop_reason": results[0]["stop_reason"],
        "iterations": results[0]["iterations"],
        "timing_s": {"solve": results[1]["timing_s"]["solve"], "total": results[1]["timing_s"]["total"]},
    }
    try:
        write_private(file, json_bytes(document))
    except OSError as error:
        raise BadInput(
            f"The results cannot be written ({error.strerror}); free space or choose another folder."
        ) from error
