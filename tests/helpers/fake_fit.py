"""Runners that stand in for run_fit in tests of queue and API: same events, same files, no numerics to wait for.

They live in a module of their own because worker processes import them by name.  Poses are the toy rig's.
"""

import json
import os
import signal
import time
from collections.abc import Iterator

import numpy as np

from breastrig.core.errors import BadScan, FitFailed
from breastrig.files.result import ResultFile
from breastrig.geometry.rotations import quaternion_from_rotation
from breastrig.gltf.pose_nodes import node_poses
from breastrig.gltf.read_rig import read_rig
from breastrig.report.files.geometry_files import surface_ply
from breastrig.rig.parameters import RigParameters, rest_parameters
from breastrig.rig.skinning import Posed
from breastrig.scan.clean import clean
from breastrig.scan.read import read_scan
from breastrig.scan.scan import Scan
from breastrig.use.steps.events import Done, Event, Iterated, NodePose, Started
from breastrig.use.steps.settings import FitJob
from helpers.results import NOTHING, TO_LANDMARKS, result_document
from helpers.toy_rig import toy_rig

ITERATIONS = 4
AT_EACH = NOTHING | {"coverage": 1.0}
DRAWN = {"name": "own", "closed": False, "color": "#101010", "points": [[0.0, 300.0, 150.0], [10.0, 300.0, 150.0]]}


def parameters_at(iteration: int) -> RigParameters:
    """The toy rig moved along and shaped a little more with each iteration."""
    rest = rest_parameters(toy_rig())
    weights = np.full(len(rest.weights), 0.01 * iteration)
    x = RigParameters(rest.rotations, rest.translations, rest.scales * (1 + 0.001 * iteration), weights)
    return x.moved(np.eye(3), np.array([0.01 * iteration, 0.0, 0.0]))


def started(job: FitJob) -> Started:
    return Started(
        stance="standing" if job.stance == "auto" else job.stance,
        stance_reason="As asked for.",
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
    """A whole fit with its files: enough of them for a share link, too little for a report."""
    yield started(job)
    for iteration in range(ITERATIONS):
        yield iterated(iteration)
    rig, x, vertices = toy_rig(), parameters_at(ITERATIONS - 1), surface(job.refine)
    scan = scan_of(job)
    seen = clean(scan)
    distances = np.full(len(vertices), 0.25, "<f4")
    files = {
        "fitted.glb": b"fitted.glb",
        "fitted.ply": surface_ply(vertices, rig.faces, scan.metres_per_unit),
        "scan.ply": surface_ply(seen.vertices, seen.faces, scan.metres_per_unit),
        "distances.bin": distances.tobytes(),
        "uncertainty.bin": distances.tobytes(),
        "drawing.json": json.dumps({"schema": "breastrig/drawing@1", "unit": "mm", "shapes": [DRAWN]}).encode(),
    }
    for name, content in files.items():
        (job.out / name).write_bytes(content)
    quaternions = quaternion_from_rotation(x.rotations)
    result = result_document(
        iterations=ITERATIONS - 1,
        landmarks_given=job.landmarks_mm,
        refined=job.refine,
        certain=list(job.certain),
        marks_given=job.marks_mm,
        confidence=job.landmark_confidence,
        stance=started(job).stance,
        scan={"unit": scan.unit, "vertices": len(seen.vertices), "triangles": len(seen.faces), "sha256": scan.sha256},
        model={"name": rig.name, "sha256": read_rig(job.model).sha256 if job.model else rig.sha256},
        surface_distance_mm=AT_EACH | {"mean": 0.2},
        model_alone={
            "surface_distance_mm": AT_EACH | {"mean": 2.0},
            "scan_to_model_mm": AT_EACH,
            "landmark_distance_mm": TO_LANDMARKS,
        },
        landmarks={"nipple_L": [1.0, 2.0, 3.0]},
        landmarks_picked=job.landmarks_mm,
        areolae={"L": {"diameter_mm": 40.0, "within_mm": 5.0, "rim": [[1.0, 2.0, 3.0]] * 3}},
        parameters={
            "bones": [
                {"name": name, "rotation_xyzw": list(turn), "translation_m": list(place), "scale": list(size)}
                for name, turn, place, size in zip(rig.bone_names, quaternions, x.translations, x.scales, strict=True)
            ],
            "blendshapes": dict(zip(rig.shape_names, x.weights.tolist(), strict=True)),
        },
    )
    last = ResultFile.model_validate(result)
    (job.out / "result.json").write_bytes(last.content())
    yield Done(result=last)


def scan_of(job: FitJob) -> Scan:
    """The job's, or the toy rig where the test's file is none."""
    try:
        return read_scan(job.scan, job.file_type, job.units, texture=False)
    except BadScan:
        return Scan(toy_rig().template, toy_rig().faces, "m", 1.0, "As asked for.", "5" * 64)


def surface(refined: bool) -> np.ndarray:
    """(V, 3) m: the toy rig where a fit ends, with a layer of 3 mm where it is refined."""
    posed = Posed(toy_rig(), parameters_at(ITERATIONS - 1)).vertices
    return posed + np.array([0.0, 0.0, 0.003]) if refined else posed


def patient(job: FitJob) -> Iterator[Event]:
    """Iterates every 20 ms for longer than anybody waits."""
    yield started(job)
    for iteration in range(5000):
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
