"""A plan on the scan of one fit: from folders of fits and a document to a document.

It reads one or more scans, and carries from each of them, so the service runs it in a process of its own.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadInput
from breastrig.drawings.drawing_file import shape_document
from breastrig.drawings.inside.lesions import BALL, Distance, PlacedLesion, Slice
from breastrig.drawings.plan_on_scan import MissingItem, PlannedLine, PlannedScan, PlanOnScan, plan_on_scan
from breastrig.drawings.plan_schema import (
    PLAN_SCHEMA,
    Plan,
    PlanItem,
    PlanLesion,
    PlanLine,
    PlanNote,
    PlanTumour,
    checked_plan,
    empty_plan_on_scan,
)
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.use.folder.fit_folder import FitFolder, fit_folder_of
from breastrig.use.folder.one_body import BodyIssue, body_doubt
from breastrig.use.folder.whose import made_on
from breastrig.use.lines.marks_between import marks_between
from breastrig.volume.tetrahedra import chest_wall

PlanLines = tuple[dict[str, Any], bool]  # a document breastrig/drawing@1 on the fit's scan


@dataclass(frozen=True)
class PlannedFit:
    """The fit of a scan that a plan names."""

    folder: Path
    scan: str = ""  # as the plan's items name it; empty: found by the plan's table of scans, or by the stance
    doubt: BodyIssue | None = None  # whether it is the job's patient, as `compared_bodies` has found; None: no doubt


@dataclass(frozen=True)
class PlanJob:
    """A plan to be laid on a scan."""

    plan: dict[str, Any]  # a document breastrig/plan@1, or breastrig/drawing@1
    fit: PlannedFit
    others: tuple[PlannedFit, ...] = ()  # of the same patient's other scans, where items were made
    model: Path | None = None  # None: the torso of the package


NOT_CARRIED = "It was made on a scan that does not look like this patient's; say whether it is, to see it here."


def compared_bodies(first: Path, second: Path, model: Path | None) -> BodyIssue | None:
    """Whether the fits in two folders are of one patient; None where nothing speaks against it.

    No plan changes the answer.  Raises BadInput for what is no fit.
    """
    rig = read_rig(model or default_rig_path())
    return body_doubt(fit_folder_of(first, rig), fit_folder_of(second, rig))


def plan_on_fit(job: PlanJob) -> dict[str, Any]:
    """The plan's lines as breastrig/drawing@1 in the scan's frame and unit; each says of which item it is.

    `asked` names the scans that do not look like this patient's: nothing is carried from them until a person says so.

    Raises BadInput for what is no plan or no fit.
    """
    rig = read_rig(job.model or default_rig_path())
    plan = checked_plan(job.plan)
    here = fit_folder_of(job.fit.folder, rig)
    fits, doubts, asked, kept_back = [(here, job.fit.scan)], [], [], []
    for other in job.others:
        doubt = other.doubt
        doubts += [] if doubt is None else [doubt.says]
        if doubt is None or not doubt.is_question:
            fits.append((fit_folder_of(other.folder, rig), other.scan))
            continue
        asked.append({"scan": other.scan, "says": doubt.says})
        kept_back += [{"item": item.id, "reason": NOT_CARRIED} for item in items_of(plan, other.scan, is_home=False)]
    try:
        found = plan_document(plan, here, plan_on_folders(rig, plan, fits))
        carried_from = [(fit, scan) for fit, scan in fits[1:] if items_of(plan, scan, is_home=False)]
        marks = [{"scan": scan} | between for fit, scan in carried_from if (between := marks_between(fit, here))]
    except MemoryError as error:
        raise BadInput("Carrying this plan needs more memory than it may use; give smaller scans.") from error
    said = {"missing": [*found["missing"], *kept_back], "doubts": doubts, "asked": asked}
    return found | said | ({"marks": marks} if marks else {})


def plan_on_folders(rig: Rig, plan: Plan, fits: Sequence[tuple[FitFolder, str]], home: int = 0) -> PlanOnScan:
    """The plan on the scan of the first of these fits; with each the name that the plan's items give its scan.

    Items that name no scan were made on that of `fits[home]`.
    """
    names = [name or scan_of_plan(plan, fit) for fit, name in fits]
    here, *others = (
        PlannedScan(fit.stance, fit.fitted_scan, items_of(plan, name, is_home=place == home))
        for place, ((fit, _), name) in enumerate(zip(fits, names, strict=True))
    )
    if any(isinstance(item, PlanLesion) for item in plan.items):
        with suppress(BadInput):  # a rig whose inside nobody knows
            here = replace(here, wall=chest_wall(rig, fits[0][0].parameters, here.scan.vertices))
    return plan_on_scan(rig, here, [other for other in others if other.items])


def scan_of_plan(plan: Plan, fit: FitFolder) -> str:
    """The plan's name of the fit's scan: by its hash, else by its stance; empty where it names no such scan."""
    sha256 = fit.result.scan.sha256
    table = {scan.id: scan for scan in plan.scans}
    by_hash = [name for name, scan in table.items() if scan.sha256 is not None and scan.sha256 == sha256]
    by_stance = [name for name, scan in table.items() if scan.stance == fit.stance]
    named = [item.scan for item in plan.items if item.scan == fit.stance]
    return next(iter([*by_hash, *by_stance, *named]), "")


def items_of(plan: Plan, name: str, is_home: bool) -> tuple[PlanItem, ...]:
    """The items of that scan; those that name none belong to the one that is at home."""
    return tuple(item for item in plan.items if (item.scan == name if item.scan else is_home))


def plan_document(plan: Plan, fit: FitFolder, found: PlanOnScan) -> dict[str, Any]:
    """breastrig/drawing@1 with, beside each line, its item, and with what is missing."""
    return (
        empty_plan_on_scan(fit.unit)
        | made_on(fit.result)
        | ({"predicted": True} if fit.result.predicted else {})
        | {
            "shapes": [_shape(each, fit.metres_per_unit) for each in found.lines],
            "lesions": [_lesion(each, fit) for each in found.lesions],
            "notes": [
                {"item": item.id, "text": item.text, "at": item.id if item.point is not None else None}
                for item in plan.items
                if isinstance(item, PlanNote)
            ],
            "missing": [_missing(each) for each in found.missing],
        }
    )


def _missing(each: MissingItem) -> dict[str, Any]:
    instead = [{"label": way.label, "name": way.name, "parameters": way.parameters} for way in each.instead]
    return {"item": each.item.id, "reason": each.reason} | ({"instead": instead} if instead else {})


def _lesion(each: PlacedLesion, fit: FitFolder) -> dict[str, Any]:
    return {
        "id": each.item.id,
        "name": each.item.name,
        "center": _place(each.center, fit),
        "radius_mm": each.item.radius_mm,
        "error_mm": None if each.error is None else round(1e3 * each.error, 2),
        "ellipsoid_mm": None if each.covariance is None else _semi_axes(each.covariance),
        "depth_mm": round(1e3 * each.depth, 2),
        "seen": each.is_seen,
        "distances": [_distance(distance, fit) for distance in each.distances],
        "slices": [_slice(cut) for cut in each.slices],
        "carried": each.is_carried,
        **_radiology(each),
    }


def _radiology(each: PlacedLesion) -> dict[str, Any]:
    """Its place as radiology writes it, and what was typed of a report beside it."""
    if each.clock is None:
        return {}
    clock, check = each.clock, each.radiology
    hour = None if clock.hour is None else round(clock.hour, 2)
    compared = {} if check is None else {"radiology": {"agrees": check.agrees, "text": check.text}}
    return {"clock": {"side": clock.side, "hour": hour, "text": clock.text}, **compared}


def _semi_axes(covariance: Array) -> list[list[float]]:
    """Semi-axes of the 90 % ellipsoid, mm: three vectors at right angles, the shortest first."""
    squares, directions = np.linalg.eigh(covariance)
    axes = 1e3 * BALL * np.sqrt(squares.clip(0.0)) * directions
    return [[float(value) for value in axis] for axis in np.round(axes.T, 3) + 0.0]


def _distance(each: Distance, fit: FitFolder) -> dict[str, Any]:
    low, high = (
        (None, None) if each.margin is None else (max(each.length - each.margin, 0.0), each.length + each.margin)
    )
    lengths = {"mm": each.length, "low_mm": low, "high_mm": high}
    return (
        {"kind": each.kind, "to": each.to, "point": _place(each.point, fit)}
        | {name: None if length is None else round(1e3 * length, 2) for name, length in lengths.items()}
        | ({"seen": True} if each.is_seen else {})
    )


def _slice(cut: Slice) -> dict[str, Any]:
    return {
        "plane": cut.plane,
        "right": [round(float(value), 6) for value in cut.right],
        "up": [round(float(value), 6) for value in cut.up],
        "outlines_mm": _millimetres(cut.outlines),
        "wall_mm": _millimetres(cut.wall),
    }


def _millimetres(outlines: Sequence[Array]) -> list[list[list[float]]]:
    return [(np.round(1e3 * outline, 1) + 0.0).tolist() for outline in outlines]


def _place(point: Array, fit: FitFolder) -> list[float]:
    return [round(float(value), 6) for value in point / fit.metres_per_unit]


def _shape(each: PlannedLine, metres_per_unit: float) -> dict[str, Any]:
    item = each.item
    depth = item.depth_mm if isinstance(item, PlanTumour) else None
    return shape_document(each.line, metres_per_unit) | {
        "item": item.id,
        "kind": item.kind,
        "carried": each.is_carried,
        **({} if depth is None else {"depth_mm": depth}),
        **({"mirrored": True} if isinstance(item, PlanLine) and item.mirrored else {}),
    }


def lesions_of(fit: FitFolder) -> list[dict[str, Any]]:
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
    plan = checked_plan({"schema": PLAN_SCHEMA, "items": lesions_of(fit)})
    return plan_document(plan, fit, plan_on_folders(fit.rig, plan, [(fit, "")]))
