"""One fit from files to files, as a stream of events: what the command line and the service both run.

Whoever stops consuming the generator cancels the fit; nothing is written then but what was already there.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadDrawing, BadLandmarks, BadSettings, FitFailed, unknown_name
from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.on_scan import on_scan
from breastrig.fitting.fit import FitIterate, FitTask, fit_iterates
from breastrig.fitting.landmark_check import Doubt, doubts, sides_exchanged
from breastrig.fitting.orientation import best_start
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.refine import refined
from breastrig.gltf.pose_nodes import node_poses
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.jobs.events import Done, DoubtedPick, Event, Iterated, NodePose, Started
from breastrig.jobs.fit_files import FitOutcome, write_fit_files
from breastrig.least_squares.newton import Status
from breastrig.report.distances import surface_distances
from breastrig.rig.model import ModelDrawing, Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import pose
from breastrig.scan.clean import clean
from breastrig.scan.orient import propose_frame
from breastrig.scan.read import read_scan

STANCES = ("auto", "standing", "supine")
ALL_EXCHANGED = "Left and right of the landmarks look exchanged, or the scan is mirrored; no landmark was followed."
FAR_LANDMARK = 0.1  # m from the scan; such a pick belongs to another scan or another unit


@dataclass(frozen=True)
class FitJob:
    """Everything that a fit needs to know, as plain values that travel between processes."""

    scan: Path
    out: Path
    landmarks_mm: dict[str, list[float]]  # name -> x y z in the scan's frame, millimetres whatever the scan's unit
    units: str = "auto"
    file_type: str | None = None  # None: from the content
    stance: str = "auto"
    preset: str = "default"
    drawing: str | None = "lumpectomy"
    model: Path | None = None  # None: the torso of the package
    refine: bool = False  # a free-form layer on top, for fitted.ply, the drawing and the numbers


def chosen_drawing(rig: Rig, name: str | None) -> ModelDrawing | None:
    """The rig's drawing of that name; None for none."""
    if name is None:
        return None
    for drawing in rig.drawings:
        if drawing.name == name:
            return drawing
    raise BadDrawing(unknown_name("drawing of this model", name, rig.drawing_names))


def checked_landmarks(rig: Rig, landmarks_mm: dict[str, list[float]]) -> dict[str, Array]:
    """Landmarks in metres; BadLandmarks names the wrong word or value."""
    result = {}
    for name, place in landmarks_mm.items():
        if name not in rig.landmark_names:
            raise BadLandmarks(unknown_name("landmark of this model", name, rig.landmark_names))
        point = np.asarray(place, dtype=np.float64)
        if point.shape != (3,) or not np.isfinite(point).all():
            raise BadLandmarks(f"The landmark {name} needs three finite numbers x y z.")
        result[name] = 1e-3 * point
    return result


def _near_the_scan(landmarks: dict[str, Array], target: ScanTarget) -> None:
    if not landmarks:
        return
    gaps, _ = target.vertex_tree.query(np.array(list(landmarks.values())))
    worst = int(np.argmax(gaps))
    if gaps[worst] > FAR_LANDMARK:
        raise BadLandmarks(
            f"The landmark {tuple(landmarks)[worst]} is {1e3 * float(gaps[worst]):.0f} mm away from the scan; "
            "check that landmarks and scan have the same unit and frame."
        )


def _iterated(rig: Rig, iterate: FitIterate, x: RigParameters) -> Iterated:
    gap = iterate.landmark_distance
    return Iterated(
        iteration=iterate.iteration,
        stage=iterate.stage,
        energy=round(float(np.nan_to_num(iterate.energy)), 6),
        mean_distance_mm=round(1e3 * iterate.mean_distance, 4),
        landmark_distance_mm=None if gap is None else round(1e3 * gap, 4),
        coverage=round(iterate.coverage, 4),
        elapsed_s=round(iterate.elapsed_s, 4),
        nodes=[NodePose.model_validate(node) for node in node_poses(rig, x)],
    )


def run_fit(job: FitJob) -> Iterator[Event]:
    """Started, Iterated …, Done; a BreastRigError instead when it cannot be done.

    Writes result.json, fitted.ply, fitted.glb, drawing.json and fit.log.jsonl into job.out before Done.
    """
    clock = [time.perf_counter()]

    def lap() -> float:
        clock.append(time.perf_counter())
        return clock[-1] - clock[-2]

    if job.stance not in STANCES:
        raise BadSettings(unknown_name("stance", job.stance, STANCES))
    recipe = load_recipe(job.preset)
    rig = read_rig(job.model or default_rig_path())
    drawing = chosen_drawing(rig, job.drawing)
    landmarks = checked_landmarks(rig, job.landmarks_mm)
    lap()
    scan = read_scan(job.scan, job.file_type, job.units, texture=False)
    timing = {"read": lap()}
    surface = clean(scan)
    centre = surface.vertices.mean(axis=0)
    target = ScanTarget(surface.vertices - centre, surface.faces)
    picked = {name: place - centre for name, place in landmarks.items()}
    _near_the_scan(picked, target)
    frame = propose_frame(target.vertices, target.faces)
    _warm(target)
    timing["prepare"] = lap()
    exchanged = (Doubt(tuple(picked), ALL_EXCHANGED),) if sides_exchanged(rig, picked) else ()
    followed = {} if exchanged else picked
    start = best_start(rig, target, followed, frame.front)
    timing["align"] = lap()
    stance = frame.stance if job.stance == "auto" else job.stance
    reason = frame.stance_reason if job.stance == "auto" else "As asked for."
    yield Started(
        stance="supine" if stance == "supine" else "standing",
        stance_reason=reason,
        preset=recipe.name,
        model_sha256=rig.sha256,
        drawing=job.drawing,
        iterations_limit=recipe.iterations_limit,
        notes=[*scan.notes, *surface.notes],
        landmarks_not_followed=[DoubtedPick(names=list(each.names), reason=each.reason) for each in exchanged],
    )
    lap()
    iterates: list[tuple[FitIterate, RigParameters]] = []
    events: list[Iterated] = []
    solve = 0.0
    task = FitTask(rig, target, start, recipe, followed, stance)
    steps = fit_iterates(task)
    while True:
        iterate = next(steps, None)
        solve += lap()
        if iterate is None:
            break
        if iterate.status is Status.NOT_FINITE or not np.isfinite(iterate.mean_distance):
            raise FitFailed(_why_failed(iterate))
        x = iterate.parameters.moved(np.eye(3), centre)
        iterates.append((iterate, x))
        events.append(_iterated(rig, iterate, x))
        yield events[-1]
        lap()
    timing["solve"] = solve
    last, x = iterates[-1]
    vertices = pose(rig, last.parameters)
    if job.refine:
        lap()
        vertices = refined(target, vertices, rig.faces).vertices
        timing["refine"] = lap()
    fitted_landmarks = rig.landmark_points().positions(vertices, rig.faces)
    found = dict(zip(rig.landmark_names, fitted_landmarks, strict=True))
    doubtful = exchanged or doubts(rig, found, followed)
    distances = surface_distances(target, vertices, rig.faces)
    lines = on_scan(rig, vertices, drawing, target) if drawing else ()
    timing["total"] = time.perf_counter() - clock[0]
    outcome = FitOutcome(
        scan=scan,
        rig=rig,
        stance=stance,
        stance_reason=reason,
        preset=recipe.name,
        parameters=x,
        vertices=vertices + centre,
        refined=job.refine,
        history=tuple(x for _, x in iterates),
        times_s=tuple(iterate.elapsed_s for iterate, _ in iterates),
        log=tuple(events),
        status=last.status,
        timing_s=timing,
        distances=distances,
        landmarks=landmarks,
        doubts=doubtful,
        drawing=drawing,
        lines=lines,
        centre=centre,
        notes=(*scan.notes, *surface.notes),
    )
    yield Done(result=write_fit_files(outcome, job.out))


def _warm(target: ScanTarget) -> None:
    """Builds what is built on first use, so that its time counts as preparation and not as solving."""
    _ = target.rays, target.search, target.vertex_tree, target.normals, target.on_border, target.face_normals


def _why_failed(iterate: FitIterate) -> str:
    if iterate.status is Status.NOT_FINITE:
        return "The fit broke down (a number is not finite); try other landmarks or another scan."
    return "The model found no skin of the scan near it; place at least three landmarks, or check the scan's unit."
