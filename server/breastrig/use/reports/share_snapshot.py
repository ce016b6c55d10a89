"""The files of a share link, made once from a fit as it is: visitors get these files, and nothing else.

With the scan they contain its visible part: parts that were cut away by hand, also after the fit, or as table, floor or
loose piece are in none of them. Without the scan they contain the model alone, as bones and shapes have it: not the
free-form layer, which follows the patient's skin to a tenth of a millimetre, no distances to the skin, no point that
was picked on it, and the plan's lines where they lie on that model.
"""

import json
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.core.documents import json_bytes
from breastrig.core.errors import BadInput, BreastRigError
from breastrig.core.identity import Identity
from breastrig.core.private_files import read_ordinary, write_private
from breastrig.core.units import METRES_PER_UNIT
from breastrig.drawings.drawing_file import FILE_BYTES, planned_on_scan
from breastrig.files.result import RESULT, ResultFile, ResultScan
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.gltf.link_mesh import coloured_mesh, plain_mesh
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.gltf.replay import fitted_glb
from breastrig.languages.catalogue import ENGLISH
from breastrig.report.files.geometry_files import surface_ply
from breastrig.rig.modes import mode_count
from breastrig.rig.skinning import in_pose
from breastrig.scan.hand_cuts import are_cut
from breastrig.scan.read import read_scan
from breastrig.use.folder.fit_folder import FitFolder, fit_folder_of, still_visible
from breastrig.use.lines.planned_glb import planned_glb
from breastrig.use.reports.report import ReportJob, report_pdf_of


@dataclass(frozen=True)
class SnapshotJob:
    """The contents of a share link to a fit, as it is now."""

    fit: Path  # folder of a fit
    plan: dict[str, Any]  # on its scan, as `service/plans.py` gives it
    items: tuple[dict[str, Any], ...]  # of the plan itself
    identity: Identity  # on the pages of the report; without the patient's code
    out: Path  # folder for the files
    scan: Path | None = None  # as it is stored, where its colours are shown
    file_type: str = ""  # of that file
    shows_scan: bool = False  # else the model alone
    has_notes: bool = False  # of the plan
    cuts: tuple[dict[str, Any], ...] = ()  # by hand, see scan/hand_cuts.py
    model: Path | None = None  # None: the torso of the package
    language: str = ENGLISH  # of the report


OF_THE_MODEL = (  # of result.json
    "notice", "model", "stance", "stance_reason", "preset", "converged", "stop_reason", "verdict",
    "iterations", "timing_s", "landmarks_not_followed", "landmarks_unusual", "landmark_uncertainty_mm", "line_error_mm",
    "landmarks_agreed", "parameters", "drawing_missing", "notes", "versions",
)  # fmt: skip
DIGITS = 6  # of a place, in the scan's unit


def write_snapshot(job: SnapshotJob) -> None:
    """Writes the files.  Raises a BreastRigError with a sentence, OSError when they cannot be written."""
    try:
        for name, content in snapshot_files(job).items():
            write_private(job.out / name, content)
    except MemoryError as error:
        raise BadInput("This scan is too large to be shown through a link; simplify it first.") from error


WHOSE = ("patient", "scan_sha256")  # of a drawing: a link does not say it


def snapshot_files(job: SnapshotJob) -> dict[str, bytes]:
    """The files by name: result.json, fitted.glb, fitted.ply, drawing.json, plan.json.

    With the scan distances.bin, mesh.glb and, where one can be made of this fit, report.pdf as well.
    """
    rig = read_rig(job.model or default_rig_path())
    whole = still_visible(fit_folder_of(job.fit, rig), job.cuts)
    fit = replace(whole, result=whole.result.without_marks())
    alone = in_pose(rig, fit.parameters).vertices
    cut = are_cut(fit.vertices, job.cuts)  # of the model: there the skin is gone, and the layer with it
    surface = np.where(cut[:, None], alone, fit.vertices) if job.shows_scan else alone
    plan = _plan(job)
    own = plan if plan["whole"] else _own_drawing(job)
    if not job.shows_scan:
        search = ClosestPointSearch(alone, rig.faces)
        plan, own = (_laid_on(search, document, fit.unit) for document in (plan, own))
    plan, own = ({key: said for key, said in each.items() if key not in WHOSE} for each in (plan, own))
    result = fit.result if job.shows_scan else _result_of_model(fit, alone)
    files = {
        RESULT: result.model_copy(update={"files": {}, "wall": None}).content(),  # other files are beside it
        "fitted.ply": surface_ply(surface, rig.faces, fit.metres_per_unit),
        "fitted.glb": _fitted_glb(fit, surface, plan, own),
        "drawing.json": json_bytes(own),
        "plan.json": json_bytes(plan),
    }
    return files if not job.shows_scan else files | _of_scan(job, fit, cut, plan)


def _of_scan(job: SnapshotJob, fit: FitFolder, cut: Booleans, plan: dict[str, Any]) -> dict[str, bytes]:
    """The files that show the skin itself."""
    files = {}
    with suppress(OSError):  # a fit of an older version has none
        distances = np.frombuffer(read_ordinary(job.fit / "distances.bin", FILE_BYTES), "<f4")
        if len(distances) == len(cut):
            files["distances.bin"] = np.where(cut, np.float32(np.nan), distances).astype("<f4").tobytes()
    if job.scan is None:
        files["mesh.glb"] = plain_mesh(fit.surface)
    else:
        files["mesh.glb"] = coloured_mesh(read_scan(job.scan, job.file_type, fit.unit), fit.surface)
    lines = (plan, bool(plan["whole"])) if plan["version"] else None
    items = tuple(item for item in job.items if job.has_notes or item["kind"] != "note")
    report = ReportJob(
        job.fit,
        model=job.model,
        plans=(lines,),
        items=items,
        identity=job.identity,
        cuts=(job.cuts,),
        names_marks=False,
        language=job.language,
    )
    with suppress(BreastRigError):  # then the link offers none
        files["report.pdf"] = report_pdf_of(report)
    return files


def _plan(job: SnapshotJob) -> dict[str, Any]:
    """The plan on the fit's scan without ids, which are the owner's, and without notes unless the owner shows them."""
    plan = dict(job.plan) | {"fit": "", "carried_from": [], "asked": []}
    plan.pop("marks", None)
    if job.has_notes:
        return plan
    return plan | {"notes": [], "shapes": [shape for shape in plan["shapes"] if shape.get("kind") != "note"]}


def _own_drawing(job: SnapshotJob) -> dict[str, Any]:
    try:
        document: dict[str, Any] = json.loads(read_ordinary(job.fit / "drawing.json", FILE_BYTES))
        planned_on_scan(document)
    except (OSError, ValueError) as error:
        raise BadInput("The fit's drawing.json is damaged; fit the scan again.") from error
    return document


def _laid_on(search: ClosestPointSearch, document: dict[str, Any], unit: str) -> dict[str, Any]:
    """A drawing with its points where they are closest to a surface of the model; lesions without cuts of the skin."""
    per_unit = METRES_PER_UNIT[document.get("unit") or unit]

    def laid(points: list[list[float]]) -> list[list[float]]:
        found = search.query(per_unit * np.array(points, dtype=np.float64)).points / per_unit
        return [[float(value) for value in point] for point in np.round(found, DIGITS)]

    shapes = [shape | {"points": laid(shape["points"])} for shape in document["shapes"]]
    lesions = [
        each | {"slices": [], "distances": [to | {"point": laid([to["point"]])[0]} for to in each["distances"]]}
        for each in document.get("lesions", [])
    ]
    return document | {"shapes": shapes} | ({"lesions": lesions} if lesions else {})


def _fitted_glb(fit: FitFolder, surface: Array, plan: dict[str, Any], own: dict[str, Any]) -> bytes:
    """The posed rig with the lines; the way there, iteration by iteration, is the owner's alone."""
    names = {line.name for line in planned_on_scan(plan)}
    refined = (fit.result.refined or mode_count(fit.rig)) and not np.array_equal(
        surface, in_pose(fit.rig, fit.parameters).vertices
    )
    extras = {"preset": fit.result.preset} | ({"predicted": True} if fit.result.predicted else {})
    glb = fitted_glb(fit.rig, [fit.parameters], [0.0], None, extras, surface if refined else None)
    return planned_glb(glb, plan, [line for line in planned_on_scan(own) if line.name not in names])


def _result_of_model(fit: FitFolder, alone: Array) -> ResultFile:
    """The result of the model alone: values that do not show the patient's skin, or only as means."""
    result = fit.result
    places = fit.rig.landmark_points().positions(alone, fit.rig.faces) / fit.metres_per_unit
    distances = result.distances if result.refined else result
    said = {name: value for name, value in result if name in OF_THE_MODEL} | {
        "schema": result.schema_,
        "scan": ResultScan(
            vertices=result.scan.vertices, triangles=result.scan.triangles, unit=result.scan.unit, sha256=""
        ),
        "refined": False,
        "surface_distance_mm": distances.surface_distance_mm,
        "scan_to_model_mm": distances.scan_to_model_mm,
        "landmark_distance_mm": distances.landmark_distance_mm,
        "landmarks": dict(zip(fit.rig.landmark_names, np.round(places, DIGITS).tolist(), strict=True)),
        "landmarks_picked": {},
    }
    return ResultFile.model_validate(said)
