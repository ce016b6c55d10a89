"""A drawing made on the scan of one fit, shown on the scan of another: from folders to a document.

It reads two scans and solves a small dense system, about a second of work in all, so the service runs it in a
process of its own, as it does with everything that reads scans.
"""

import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from breastrig.core.errors import BadDrawing, BadInput, TooLarge
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.private_files import read_ordinary, shown
from breastrig.drawings.drawing_file import (
    FILE_BYTES,
    Drawing,
    lines_on_scan,
    millimetres,
    parsed_drawing,
    shape_document,
)
from breastrig.drawings.on_skin import moved_onto_skin
from breastrig.drawings.plan_schema import PLAN_SCHEMA, Plan, PlanLine, checked_plan, is_plan
from breastrig.drawings.project_drawing import on_scan
from breastrig.drawings.transfer import TransferredLine, transferred
from breastrig.geometry.polyline import Polyline
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import ModelDrawing, Rig
from breastrig.use.folder.fit_folder import FitFolder, fit_folder_of
from breastrig.use.folder.one_body import check_one_body, doubts_between
from breastrig.use.folder.whose import check_whose, made_on
from breastrig.use.lines.plan_on_fit import items_of, plan_document, plan_on_folders, scan_of_plan


@dataclass(frozen=True)
class TransferJob:
    """A drawing on the scan of one fit, wanted on that of another."""

    from_fit: Path  # folder of a fit
    to_fit: Path
    drawing: (
        dict[str, Any] | None
    )  # a document breastrig/drawing@1 or breastrig/plan@1; None: the drawing that the first fit left
    other_patient: bool = False  # the scans are of two patients: the model decides which skin is which
    model: Path | None = None  # None: the torso of the package
    same_patient: bool = False  # a person has said that the drawing is this patient's, whatever its file says
    one_patient: bool = False  # and that both scans are of one, whatever their bodies say


def drawing_document(file: Path) -> dict[str, Any]:
    """A drawing file's JSON object."""
    try:
        content = read_ordinary(file, FILE_BYTES)
        if len(content) > FILE_BYTES:
            raise TooLarge(f"{shown(file.name)} is larger than {FILE_BYTES // 1_000_000} MB; this is no drawing.")
    except OSError as error:
        raise BadDrawing(f"There is no drawing {shown(file.name)} that can be read; check the name.") from error
    try:
        document = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise BadDrawing(f"{file.name} is not JSON; give a file such as drawing.json that a fit leaves.") from error
    if not isinstance(document, dict):
        raise BadDrawing(f"{file.name} is no drawing; it must hold a JSON object of the form breastrig/drawing@1.")
    return document


def transfer(job: TransferJob) -> dict[str, Any]:
    """The drawing on the target scan (breastrig/drawing@1), in its frame and unit.

    Raises BadInput, of it NeedsYes for a drawing that is another patient's, and for scans that look like two patients'.
    """
    return transfer_with(read_rig(job.model or default_rig_path()), job)


def transfer_with(rig: Rig, job: TransferJob) -> dict[str, Any]:
    """The transferred drawing, as `transfer`, with a rig that has been read."""
    source, goal = fit_folder_of(job.from_fit, rig), fit_folder_of(job.to_fit, rig)
    if job.drawing is not None:
        check_whose(job.drawing, (source.result, goal.result), job.same_patient)
    if not job.other_patient:
        check_one_body(source, goal, job.one_patient)
    if job.drawing is not None and is_plan(job.drawing):
        return _plan_on(rig, checked_plan(job.drawing), source, goal, job.other_patient)
    if job.drawing is None and source.result.lesions and not job.other_patient:
        return _plan_on(rig, _with_lesions(job.from_fit, source), source, goal, other_patient=False)
    given = _own(job.from_fit, source) if job.drawing is None else parsed_drawing(job.drawing, rig, source.unit)
    a = source.fitted_scan
    b = goal.fitted_scan
    shapes = list(given.on_scan)
    if given.on_model:
        drawn = ModelDrawing(given.name, given.name, given.on_model)
        shapes += on_scan(rig, a.vertices, drawn, a.target)
    try:
        carried = transferred(rig, a, b, shapes, job.other_patient)
    except MemoryError as error:
        raise BadInput("Carrying this drawing needs more memory than it may use; give smaller scans.") from error
    doubts = [] if job.other_patient else doubts_between(source, goal)
    found = _document(given, goal, carried, job.other_patient)
    return found | {"doubts": doubts, "moved": _moved(source, given.on_scan)}


def _moved(source: FitFolder, lines: Iterable[Polyline]) -> list[str]:
    """A sentence for each line on the source's scan whose points were moved onto its skin."""
    search = source.fitted_scan.target.search
    said = (moved_onto_skin(line, search.query(line.points).distances) for line in lines)
    return [sentence for sentence in said if sentence is not None]


def _own(folder: Path, fit: FitFolder) -> Drawing:
    """The fit's own drawing, of any size."""
    document = drawing_document(folder / "drawing.json")
    lines = lines_on_scan(document, fit.unit)
    if not lines:
        raise BadDrawing("This fit has left no lines; give a drawing.")
    return Drawing(str(document.get("name") or "drawing"), lines, ())


def _with_lesions(folder: Path, fit: FitFolder) -> Plan:
    """A plan of the fit's own drawing and of what its label map shows inside."""
    lines = [each.model_dump(mode="json") for each in checked_plan(drawing_document(folder / "drawing.json")).items]
    return checked_plan({"schema": PLAN_SCHEMA, "items": [*lines, *_lesions(fit)]})


def _lesions(fit: FitFolder) -> list[dict[str, Any]]:
    """The fit's lesions as items of a plan."""
    to_mm = 1e3 * fit.metres_per_unit
    return [
        {
            "kind": "lesion",
            "id": f"lesion-{number}",
            "name": each.name,
            "center": [to_mm * value for value in each.center],
            "radius_mm": each.radius_mm,
        }
        for number, each in enumerate(fit.result.lesions, 1)
    ]


def lesions_document(fit: FitFolder) -> dict[str, Any]:
    """The lesions of the fit's label map, as a plan on its own scan."""
    plan = checked_plan({"schema": PLAN_SCHEMA, "items": _lesions(fit)})
    return plan_document(plan, fit, plan_on_folders(fit.rig, plan, [(fit, "")]))


def _plan_on(rig: Rig, plan: Plan, source: FitFolder, goal: FitFolder, other_patient: bool) -> dict[str, Any]:
    """The whole plan on the target: what was made on it as it is, all else carried from the source."""
    if other_patient:
        raise BadDrawing("A plan is one patient's; give a drawing to show it on another one.")
    laid = plan_on_folders(rig, plan, [(goal, ""), (source, "")], home=1)
    shapes = [
        item.model_dump(mode="json")
        for item in items_of(plan, scan_of_plan(plan, source), is_home=True)
        if isinstance(item, PlanLine)
    ]
    missing = {each.item.id for each in laid.missing}
    lines = lines_on_scan({"unit": "mm", "shapes": [each for each in shapes if each["id"] not in missing]}, "mm")
    return plan_document(plan, goal, laid) | {"doubts": doubts_between(source, goal), "moved": _moved(source, lines)}


def _document(
    given: Drawing, goal: FitFolder, carried: tuple[TransferredLine, ...], other_patient: bool
) -> dict[str, Any]:
    return {
        "schema": "breastrig/drawing@1",
        "name": given.name,
        "unit": goal.unit,
        "notice": LIMITS_OF_USE,
        **made_on(goal.result),
        "carried_by": "model" if other_patient else "skin",
        "shapes": [
            shape_document(each.line, goal.metres_per_unit)
            | {
                "distance_from_mm": millimetres(each.distance_from),
                "distance_to_mm": millimetres(each.distance_to),
            }
            for each in carried
        ],
    }
