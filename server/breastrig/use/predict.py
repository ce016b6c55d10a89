"""A fit of the same patient in a stance that was not scanned: the files of a fit, marked as predicted.

What the scan has seen is moved, skin, lines and landmarks, as the prediction moves the fitted model.  What lies inside
does not follow the skin alone: `breastrig transfer` carries it, with the prediction's radius.

A service has it as a stream of events, as fits (fit.py): who stops consuming the generator cancels it; nothing is
written then.
"""

from collections.abc import Callable, Generator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.documents import json_bytes
from breastrig.core.errors import BadInput
from breastrig.core.one_thread import one_thread
from breastrig.core.private_files import write_files
from breastrig.core.scratch import scratch_folder
from breastrig.core.stances import PRONE, Stance
from breastrig.core.units import METRES_PER_UNIT
from breastrig.correspondence.distances import signed_distances
from breastrig.drawings.drawing_file import drawing_document, lines_on_scan, rounded_mm, shape_document
from breastrig.drawings.line_error import drawn_error, with_errors
from breastrig.files.result import (
    BODY,
    CHECKS,
    FIT_FILES,
    RESULT,
    UNCERTAINTY,
    MedianPlane,
    ResultFile,
    Verdict,
    joint_covariance,
    parsed_result,
    read_result,
)
from breastrig.fitting.posterior import contribution_bytes
from breastrig.fitting.uncertainty.radii import HOLDS_90, line_error
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.gltf.replay import fitted_glb
from breastrig.report.body_frame import body_frame
from breastrig.report.files.geometry_files import surface_ply
from breastrig.rig.model import Rig
from breastrig.use.folder.fit_folder import fit_folder_of
from breastrig.use.steps.events import Done, Event, Started
from breastrig.use.transfer import READ, folder_of
from breastrig.use.values.fit_result import Fit
from breastrig.use.values.model import Model, loaded
from breastrig.volume.predicted import predicted


def predict(fit: Fit | str | Path, stance: Stance, model: Model = None) -> Fit:
    """The patient of a fit, or of its folder, in another `stance`: standing, supine or prone.

    The trunk stays in the scan's unit and frame; `uncertainty` (V,) holds the true place with 90 %, prediction and
    fit together.  The result says `predicted`; drawings are transferred to it as to a fit.  `model` is that of
    folders.  Raises BadInput, also for a model of which nobody knows what gravity does to it.
    """
    rig = fit.model if isinstance(fit, Fit) else loaded(model)
    with one_thread(), folder_of(fit, (*READ, "drawing.json")) as folder, scratch_folder() as made:
        write_files(prediction(rig, folder, stance), made)
        return Fit.load(made, rig)


SAYS = "predicted: no scan shows this body"  # inside each file that may travel alone


def prediction(rig: Rig, folder: Path, goal: Stance) -> dict[str, bytes]:
    """FIT_FILES by name, of the fit in `folder` as the patient would be in `goal`.  Raises BadInput."""
    fit = fit_folder_of(folder, rig)
    if fit.result.predicted:
        raise BadInput("This fit is itself predicted; predict from the fit of a scan.")
    found = predicted(rig, fit.vertices, fit.stance, goal)
    radii = found.radii if fit.radii is None else np.hypot(found.radii, fit.radii)
    search = fit.fitted_scan.search(rig)
    moves = found.vertices - fit.vertices

    def moved(points: Array) -> Array:
        """(M, 3) m: skin at (M, 3) points follows the model nearest to it."""
        nearest = search.query(points)
        return points + SurfacePoints(nearest.faces, nearest.barycentric).positions(moves, rig.faces)

    per_unit = fit.metres_per_unit

    def moved_by_unit(points: Any) -> list[list[float]]:
        places: list[list[float]] = np.round(moved(per_unit * np.array(points).reshape(-1, 3)) / per_unit, 6).tolist()
        return places

    drawing = drawing_document(folder / "drawing.json")
    lines = with_errors(rig, search, radii, lines_on_scan(drawing, fit.unit))
    drawing["shapes"] = [shape_document(replace(line, points=moved(line.points)), per_unit) for line in lines]
    said = f"Predicted from the {fit.stance} scan: no scan shows the patient {goal}."
    shown = signed_distances(fit.fitted_scan.target, fit.vertices, rig.faces)  # lines lie on skin that the scan shows
    result = _result(rig, fit.result, found.vertices, radii, goal, said, moved_by_unit)
    errors = {"line_error_mm": line_error(rig, radii, np.isfinite(shown)), "drawn_line_error_mm": drawn_error(lines)}
    result = result.model_copy(update={name: rounded_mm(error) for name, error in errors.items()})
    surface = surface_ply(moved(fit.surface.vertices), fit.surface.faces, per_unit, SAYS)
    made = {
        "scan.ply": surface,
        "fitted.ply": surface_ply(found.vertices, rig.faces, per_unit, SAYS),
        "fitted.glb": fitted_glb(rig, [fit.parameters], [0.0], None, {"predicted": True}, found.vertices),
        "drawing.json": json_bytes(drawing),
        "distances.bin": np.full(len(moves), np.nan, "<f4").tobytes(),
        UNCERTAINTY: (1e3 * radii).astype("<f4").tobytes(),
        BODY: contribution_bytes(None if fit.stance == PRONE else fit.body),  # of a trunk that was seen
        CHECKS: b"",  # nobody can look at what no scan shows
        "fit.log.jsonl": b"",
    }
    made[RESULT] = result.beside(made).content()
    return {name: made[name] for name in FIT_FILES}


def _enlarged(upper: list[float], radii: Array) -> list[float]:
    """The landmarks' joint covariance, mm², as an upper triangle, with variances raised to their (L,) mm radii."""
    joint = joint_covariance(upper, len(radii))
    if joint is None:
        return []
    more = (radii / HOLDS_90) ** 2 - np.diag(joint).reshape(-1, 3).sum(axis=1)
    joint = joint + np.diag(np.repeat(np.maximum(more, 0.0) / 3.0, 3))
    return [round(float(value), 3) for value in joint[np.triu_indices(len(joint))]]


def _result(
    rig: Rig,
    given: ResultFile,
    vertices: Array,
    radii: Array,
    goal: Stance,
    said: str,
    moved: Callable[[Any], list[list[float]]],
) -> ResultFile:
    names = list(given.landmarks)
    points = rig.landmark_points(tuple(given.landmark_uncertainty_mm or ()))
    within = 1e3 * radii[rig.faces[points.faces]]
    frame = body_frame(rig, vertices)
    normal = frame.axes[:, 0]
    radii_mm = np.einsum("lc,lc->l", within, points.barycentric)
    per_unit = METRES_PER_UNIT[given.scan.unit]
    plane = MedianPlane(normal=normal.tolist(), offset=float(normal @ frame.middle) / per_unit)
    return given.model_copy(
        update={
            "predicted": True,
            "stance": goal,
            "stance_reason": said,
            "refined": True,
            "verdict": Verdict(level="check", reasons=(said,)),
            "landmarks": dict(zip(names, moved(list(given.landmarks.values())), strict=True)),
            "landmarks_picked": dict(
                zip(given.landmarks_picked, moved(list(given.landmarks_picked.values())), strict=True)
            ),
            "marks": {
                name: mark.model_copy(update={"point": moved([mark.point])[0]}) for name, mark in given.marks.items()
            },
            "landmark_uncertainty_mm": {
                name: round(float(radius), 2)
                for name, radius in zip(given.landmark_uncertainty_mm, radii_mm, strict=True)
            },
            "landmark_covariance_mm2": _enlarged(given.landmark_covariance_mm2, radii_mm),
            "arm_angles_deg": {},
            "areolae": {},
            "lesions": [],
            "wall": None,
            "median_plane": plane,
        }
    )


@dataclass(frozen=True)
class PredictionJob:
    """A stance that was not scanned, from files to files."""

    fit: Path  # folder of a fit
    out: Path
    stance: Stance
    drawing: str | None = None  # that the fit was asked for
    model: Path | None = None  # None: the torso of the package


def run_prediction(job: PredictionJob) -> Generator[Event, None, None]:
    """Started, Done; a BreastRigError instead when it cannot be done.

    Writes the files of a fit before Done.
    """
    rig, given = read_rig(job.model or default_rig_path()), read_result(job.fit)
    yield Started(
        stance=job.stance,
        stance_reason=f"It was asked for; the scan is {given.stance}.",
        preset=given.preset,
        model_sha256=rig.sha256,
        drawing=job.drawing,
        iterations_limit=0,
    )
    files = prediction(rig, job.fit, job.stance)
    write_files(files, job.out)
    yield Done(result=parsed_result(files[RESULT], job.fit.name))
