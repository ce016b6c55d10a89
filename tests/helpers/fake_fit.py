"""Runners that stand in for run_fit in tests of queue and API: same events, same files, no numerics to wait for.

They live in a module of their own because worker processes import them by name.  Poses are the toy rig's.
"""

import json
import os
import signal
import time
from collections.abc import Iterator

import numpy as np

from breastrig.core.errors import FitFailed
from breastrig.gltf.pose_nodes import node_poses
from breastrig.rig.parameters import RigParameters, rest_parameters
from breastrig.workflow.events import Done, Event, Iterated, NodePose, Started
from breastrig.workflow.jobs import FitJob
from helpers.toy_rig import toy_rig

ITERATIONS = 4


def parameters_at(iteration: int) -> RigParameters:
    """The toy rig moved along and shaped a little more with each iteration."""
    rest = rest_parameters(toy_rig())
    weights = np.full(len(rest.weights), 0.01 * iteration)
    x = RigParameters(rest.rotations, rest.translations, rest.scales * (1 + 0.001 * iteration), weights)
    return x.moved(np.eye(3), np.array([0.01 * iteration, 0.0, 0.0]))


def started(job: FitJob) -> Started:
    return Started(
        stance="standing" if job.stance == "auto" else job.stance,
        stance_reason="A test said so.",
        preset=job.preset,
        model_sha256="0" * 64,
        drawing=job.drawing,
        iterations_limit=ITERATIONS,
    )


def iterated(iteration: int) -> Iterated:
    return Iterated(
        iteration=iteration,
        stage="all",
        energy=10.0 - iteration,
        mean_distance_mm=5.0 - iteration,
        landmark_distance_mm=None,
        coverage=0.9,
        elapsed_s=0.01 * iteration,
        nodes=[NodePose.model_validate(node) for node in node_poses(toy_rig(), parameters_at(iteration))],
    )


def quick(job: FitJob) -> Iterator[Event]:
    """A whole fit with its files."""
    yield started(job)
    for iteration in range(ITERATIONS):
        yield iterated(iteration)
    result = {"schema": "breastrig/result@1", "iterations": ITERATIONS - 1, "landmarks_given": job.landmarks_mm}
    result["refined"] = job.refine
    result["certain"] = list(job.certain)
    result["confidence"] = job.landmark_confidence
    for name in ("fitted.glb", "fitted.ply", "distances.bin", "uncertainty.bin"):
        (job.out / name).write_bytes(name.encode())
    (job.out / "drawing.json").write_text('{"schema": "breastrig/drawing@1", "unit": "mm", "shapes": []}')
    (job.out / "result.json").write_text(json.dumps(result))
    yield Done(result=result)


def patient(job: FitJob) -> Iterator[Event]:
    """Iterates every 20 ms for ten seconds."""
    yield started(job)
    for iteration in range(500):
        yield iterated(iteration)
        (job.out / "partial").write_text(str(iteration))
        time.sleep(0.02)


def unhurried(job: FitJob) -> Iterator[Event]:
    """A whole fit with its files that takes most of a second."""
    for event in quick(job):
        time.sleep(0.12)
        yield event


def unhurried_or_slow(job: FitJob) -> Iterator[Event]:
    """With the preset "paper" it takes some seconds, so that it is surely under way when it is looked at."""
    for event in quick(job):
        time.sleep(0.6 if job.preset == "paper" else 0.12)
        yield event


def hanging(job: FitJob) -> Iterator[Event]:
    """Never comes back by itself."""
    yield started(job)
    while True:
        time.sleep(1)


def failing(job: FitJob) -> Iterator[Event]:
    yield started(job)
    raise FitFailed("The model found no skin near it; place three landmarks.")


def by_process(job: FitJob) -> Iterator[Event]:
    """Says in which process it ran."""
    yield started(job)
    raise FitFailed(f"process {os.getpid()}")


def broken(job: FitJob) -> Iterator[Event]:
    yield started(job)
    raise ZeroDivisionError("an error of ours")


def dying(job: FitJob) -> Iterator[Event]:
    """The whole process is killed, as for want of memory."""
    yield started(job)
    os.kill(os.getpid(), signal.SIGKILL)
    yield iterated(0)


def greedy(job: FitJob) -> Iterator[Event]:
    """Asks for more memory than any limit allows."""
    yield started(job)
    bytearray(2**45)


def silent(job: FitJob) -> Iterator[Event]:
    """Forgets to end."""
    yield started(job)


def mostly_patient(job: FitJob) -> Iterator[Event]:
    """The preset chooses: "paper" is patient, everything else quick."""
    return patient(job) if job.preset == "paper" else quick(job)


def quick_pair(first: FitJob, second: FitJob) -> Iterator[tuple[int, Event]]:
    """The events of both, step by step, as of one job."""
    for events in zip(quick(first), quick(second), strict=True):
        yield from enumerate(events)


def patient_pair(first: FitJob, second: FitJob) -> Iterator[tuple[int, Event]]:
    for events in zip(patient(first), patient(second), strict=True):
        yield from enumerate(events)


def failing_pair(first: FitJob, second: FitJob) -> Iterator[tuple[int, Event]]:
    yield 0, started(first)
    yield 1, started(second)
    raise FitFailed("The model found no skin near it; place three landmarks.")


def half_dying_pair(first: FitJob, second: FitJob) -> Iterator[tuple[int, Event]]:
    """The first is done when the process is killed."""
    yield 1, started(second)
    for event in quick(first):
        yield 0, event
    os.kill(os.getpid(), signal.SIGKILL)


def mostly_patient_pair(first: FitJob, second: FitJob) -> Iterator[tuple[int, Event]]:
    return patient_pair(first, second) if first.preset == "paper" else quick_pair(first, second)
