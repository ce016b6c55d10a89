"""What a fit of one scan does before its first and after its last iteration; the iterations are someone else's.

The single fit and the fit of two stances share it: both make each scan ready, tell its story, and leave its files.
"""

import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadLandmarks, BadSettings, FitFailed, unknown_name
from breastrig.core.units import BEYOND, distance_text
from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.patterns import AskedDrawing, asked_drawing
from breastrig.drawings.project_drawing import on_scan
from breastrig.fitting.fit import FitIterate, FitTask
from breastrig.fitting.landmark_outliers import Doubt, doubts, sides_exchanged
from breastrig.fitting.orientation import MIN_LANDMARKS
from breastrig.fitting.prepare_scan import AUTO, prepared
from breastrig.fitting.propose import expected_error
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.refine import refined
from breastrig.fitting.scan_orientation import orientation_from
from breastrig.fitting.verdicts.fit_signals import fit_signals
from breastrig.fitting.verdicts.verdict import verdict, verdict_limits
from breastrig.gltf.pose_nodes import node_poses
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.least_squares.newton import Status
from breastrig.report.distances import surface_distances
from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.skinning import pose
from breastrig.scan.clean import clean
from breastrig.scan.read import read_scan
from breastrig.scan.scan import Scan
from breastrig.workflow.events import Done, DoubtedPick, Iterated, NodePose, Started
from breastrig.workflow.fit_files import FitOutcome, write_fit_files
from breastrig.workflow.fit_start import EarlierFit, with_earlier_start, with_stance, with_start

STANCES = (AUTO, "standing", "supine")
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
    drawing: str | None = "lumpectomy"  # see drawings/patterns.py: names, patterns with parameters, joined by +
    model: Path | None = None  # None: the torso of the package
    landmark_confidence: dict[str, float] = field(default_factory=dict)  # 0 to 1, of proposed ones; absent: 1
    refine: bool = False  # a free-form layer on top, for fitted.ply, the drawing and the numbers
    earlier: EarlierFit | None = None  # None: the start is found from landmarks and scan
    orientation: dict[str, Any] | None = None  # of the scan, found at its upload; see fitting/scan_orientation.py


class Clock:
    """Seconds since the last call, and since the beginning."""

    def __init__(self) -> None:
        self._began = self._last = time.perf_counter()

    def lap(self) -> float:
        now = time.perf_counter()
        passed, self._last = now - self._last, now
        return passed

    def total(self) -> float:
        return time.perf_counter() - self._began


def checked_landmarks(rig: Rig, landmarks_mm: dict[str, list[float]]) -> dict[str, Array]:
    """Landmarks in metres; BadLandmarks names the wrong word or value."""
    result = {}
    for name, place in landmarks_mm.items():
        if name not in rig.landmark_names:
            raise BadLandmarks(unknown_name("landmark of this model", name, rig.landmark_names))
        point = np.asarray(place, dtype=np.float64)
        if point.shape != (3,) or not np.isfinite(point).all():
            raise BadLandmarks(f"The landmark {name} needs three finite numbers x y z.")
        if np.abs(point).max() > BEYOND:
            raise BadLandmarks(f"The landmark {name} has a coordinate beyond all reason; check the file and its unit.")
        result[name] = 1e-3 * point
    return result


def _near_the_scan(landmarks: dict[str, Array], target: ScanTarget) -> None:
    if not landmarks:
        return
    gaps = np.atleast_1d(target.vertex_tree.query(np.array(list(landmarks.values())))[0])
    worst = int(np.argmax(gaps))
    if gaps[worst] > FAR_LANDMARK:
        raise BadLandmarks(
            f"The landmark {tuple(landmarks)[worst]} is {distance_text(float(gaps[worst]))} away from the scan; "
            "check that landmarks and scan have the same unit and frame."
        )


@dataclass(frozen=True, eq=False)
class ReadyScan:
    """A scan with its task, before the first iteration."""

    job: FitJob
    scan: Scan
    notes: tuple[str, ...]
    table_triangles: int  # cut away as table
    landmarks: dict[str, Array]  # picked, m, in the scan's frame
    exchanged: tuple[Doubt, ...]
    drawing: AskedDrawing | None
    stance_reason: str
    task: FitTask
    clearness: float | None  # of the start, where the scan alone placed it
    begun: tuple[FitIterate, ...]  # all iterates of the task's fit, where they were needed to find the stance
    timing_s: dict[str, float]  # solve is what the stance took

    @property
    def started(self) -> Started:
        return Started(
            stance="supine" if self.task.stance == "supine" else "standing",
            stance_reason=self.stance_reason,
            preset=self.task.recipe.name,
            model_sha256=self.task.rig.sha256,
            drawing=self.job.drawing,
            iterations_limit=self.task.recipe.iterations_limit,
            notes=list(self.notes),
            landmarks_not_followed=[DoubtedPick(names=list(d.names), reason=d.reason) for d in self.exchanged],
        )


def read_model(job: FitJob) -> Rig:
    """The job's rig."""
    return read_rig(job.model or default_rig_path())


def made_ready(job: FitJob, rig: Rig) -> ReadyScan:
    """Reads, cleans and indexes the scan and finds the start; a BadInput says what is wrong with it."""
    if job.stance not in STANCES:
        raise BadSettings(unknown_name("stance", job.stance, STANCES))
    recipe = load_recipe(job.preset)
    drawing = None if job.drawing is None else asked_drawing(rig, job.drawing)
    landmarks = checked_landmarks(rig, job.landmarks_mm)
    clock = Clock()
    scan = read_scan(job.scan, job.file_type, job.units, texture=False)
    timing = {"read": clock.lap()}
    orientation = orientation_from(job.orientation, rig)
    wished = job.earlier.stance if job.earlier is not None and job.stance == AUTO else job.stance
    ready = prepared(clean(scan), wished, None if orientation is None else orientation.frame)
    target = ready.target
    _near_the_scan(landmarks, target)
    _warm(target)
    timing["prepare"] = clock.lap()
    exchanged = (Doubt(tuple(landmarks), ALL_EXCHANGED),) if sides_exchanged(rig, landmarks, recipe.outliers) else ()
    followed = {} if exchanged else landmarks
    errors = {name: expected_error(share) for name, share in job.landmark_confidence.items()}
    task = FitTask(rig, target, rest_parameters(rig), recipe, followed, landmark_errors=errors)
    if job.earlier is None:
        task, clearness = with_start(task, ready, orientation)
        timing["align"] = clock.lap()
        task, stance = with_stance(task, job.stance, ready, orientation)
    else:
        task, stance = with_earlier_start(task, job.stance, job.earlier)
        clearness = None
        timing["align"] = clock.lap()
    timing["solve"] = clock.lap()
    return ReadyScan(
        job=job,
        scan=scan,
        notes=(*scan.notes, *ready.notes),
        table_triangles=ready.table_triangles,
        landmarks=landmarks,
        exchanged=exchanged,
        drawing=drawing,
        stance_reason=stance.reason,
        task=task,
        clearness=clearness,
        begun=stance.iterates,
        timing_s=timing,
    )


@dataclass(eq=False)
class ScanStory:
    """What has been told of one scan's iterations, and the files at the end."""

    ready: ReadyScan
    _iterates: list[FitIterate] = field(default_factory=list)
    _events: list[Iterated] = field(default_factory=list)

    def told(self, iterate: FitIterate) -> Iterated:
        """The event of an iterate; FitFailed when the fit broke down."""
        if iterate.status is Status.NOT_FINITE or not np.isfinite(iterate.mean_distance):
            raise FitFailed(_why_failed(iterate))
        self._iterates.append(iterate)
        self._events.append(_iterated(self.ready.task.rig, iterate))
        return self._events[-1]

    def finished(self, solve_s: float, clock: Clock) -> Done:
        """Writes the seven files into the job's folder; FitFailed, and no files, when this is no torso."""
        ready, last = self.ready, self._iterates[-1]
        rig, target = ready.task.rig, ready.task.target
        signals = fit_signals(rig, target, last.parameters, ready.clearness)
        placed = len(ready.task.landmarks) >= MIN_LANDMARKS
        found_verdict = verdict(signals, last.status, verdict_limits(rig.name), placed)
        if not found_verdict.is_torso:
            raise FitFailed(found_verdict.refusal)
        timing = ready.timing_s | {"solve": solve_s}
        vertices = pose(rig, last.parameters)
        if ready.job.refine:
            clock.lap()
            vertices = refined(target, vertices, rig.faces).vertices
            timing["refine"] = clock.lap()
        fitted_landmarks = rig.landmark_points().positions(vertices, rig.faces)
        found = dict(zip(rig.landmark_names, fitted_landmarks, strict=True))
        doubtful = ready.exchanged or doubts(
            rig, ready.task.recipe.outliers, found, ready.task.landmarks, last.not_followed
        )
        distances = surface_distances(target, vertices, rig.faces)
        drawing = ready.drawing.on_model(rig, vertices) if ready.drawing else None
        lines = on_scan(rig, vertices, drawing, target) if drawing else ()
        timing["total"] = clock.total()
        outcome = FitOutcome(
            scan=ready.scan,
            target=target,
            rig=rig,
            stance=ready.task.stance,
            stance_reason=ready.stance_reason,
            preset=ready.task.recipe.name,
            parameters=last.parameters,
            vertices=vertices,
            refined=ready.job.refine,
            history=tuple(iterate.parameters for iterate in self._iterates),
            times_s=tuple(iterate.elapsed_s for iterate in self._iterates),
            log=tuple(self._events),
            status=last.status,
            timing_s=timing,
            distances=distances,
            landmarks=ready.landmarks,
            doubts=doubtful,
            drawing=drawing,
            lines=lines,
            notes=ready.notes,
            table_triangles=ready.table_triangles,
            verdict=found_verdict,
        )
        return Done(result=write_fit_files(outcome, ready.job.out))


def _iterated(rig: Rig, iterate: FitIterate) -> Iterated:
    gap = iterate.landmark_distance
    return Iterated(
        iteration=iterate.iteration,
        stage=iterate.stage,
        energy=round(float(np.nan_to_num(iterate.energy)), 6),
        mean_distance_mm=round(1e3 * iterate.mean_distance, 4),
        landmark_distance_mm=None if gap is None else round(1e3 * gap, 4),
        coverage=round(iterate.coverage, 4),
        elapsed_s=round(iterate.elapsed_s, 4),
        nodes=[NodePose.model_validate(node) for node in node_poses(rig, iterate.parameters)],
    )


def _warm(target: ScanTarget) -> None:
    """Builds what is built on first use, so that its time counts as preparation and not as solving."""
    _ = target.rays, target.search, target.vertex_tree, target.normals, target.on_border, target.face_normals
    target.may_be_within(target.vertices[:1], 0.0)


def _why_failed(iterate: FitIterate) -> str:
    if iterate.status is Status.NOT_FINITE:
        return "The fit broke down (a number is not finite); try other landmarks or another scan."
    return "The model found no skin of the scan near it; place at least three landmarks, or check the scan's unit."
