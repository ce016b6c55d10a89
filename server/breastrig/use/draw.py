"""Lines, patterns and lesions drawn on the scan of a finished fit, for programs."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from breastrig.core.errors import BadDrawing
from breastrig.core.one_thread import one_thread
from breastrig.core.units import distance_text
from breastrig.drawings.drawing_file import drawing_document, shape_document
from breastrig.drawings.line_error import with_errors
from breastrig.drawings.patterns import asked_drawing, tumour_text
from breastrig.drawings.plan_schema import PLAN_SCHEMA, Plan, checked_plan
from breastrig.drawings.prepare_polyline import prepared
from breastrig.geometry.polyline import Polyline
from breastrig.rig.model import Rig
from breastrig.use.folder.fit_folder import FitFolder
from breastrig.use.folder.whose import check_whose
from breastrig.use.lines.plan_on_fit import plan_document, plan_on_folders
from breastrig.use.values.drawing import BLACK, Drawing, Lesion, Line, document_of, drawing_of
from breastrig.use.values.fit_result import Fit

Drawn: TypeAlias = str | Path | Line | Lesion | Drawing | Mapping[str, Any] | Sequence[Line | Lesion]
ROUGH = 0.05  # m that a rough place may be off the scan


def draw(fit: Fit, drawing: Drawn | None = None, tumours: Sequence[str] = (), *, same_patient: bool = False) -> Drawing:
    """A drawing made on the scan of a finished fit, in that scan's unit and frame.

    Args:
        fit: On whose scan it is made.
        drawing: A pattern in mm ("reduction:areola_mm=42"), a drawing of the model by its name, several joined by +;
            `Line` and `Lesion` objects in the scan's unit and frame; a document breastrig/plan@1 or drawing@1, or its
            Path.
        tumours: Circles on the skin, as in `fit`: "L:10,45,12".
        same_patient: Whether the document is this patient's though it names another's code and scan.

    Returns:
        Lines with `error_mm` (M,) where it is known; lesions with depth and distances.

    Raises:
        BadDrawing: Also for a pattern that does not fit on this patient, with the reason.
        NeedsYes: For a document that was made for another patient.
    """
    found = fit.in_metres
    with one_thread():
        plan = _plan(fit, drawing, tumours, same_patient)
        laid = plan_on_folders(found.rig, plan, [(found, "")])
        if laid.missing:
            raise BadDrawing(laid.missing[0].reason)
        return drawing_of(plan_document(plan, found, laid), fit.inputs)


def project(fit: Fit, points: ArrayLike, name: str = "line", *, closed: bool = False, color: str = BLACK) -> Line:
    """A line along the skin of the fit's scan through rough places (M, 3), in its unit and frame.

    Places are moved to the nearest skin, by at most 50 mm; between them the line follows the shortest way along the
    body.  `error_mm` (M,) holds each point's true place with 90 %.  Raises BadDrawing.
    """
    found = fit.in_metres
    given = document_of([Line(name, np.asarray(points), closed, color)])["shapes"][0]["points"]
    places = found.metres_per_unit * np.array(given, dtype=np.float64).reshape(-1, 3)
    if not len(places) or not np.isfinite(places).all():
        raise BadDrawing(f'"{name}" needs at least one place of three finite numbers.')
    with one_thread():
        scan = found.fitted_scan
        nearest = scan.target.search.query(places)
        if (farthest := float(nearest.distances.max())) > ROUGH:
            raise BadDrawing(
                f'A place of "{name}" is {distance_text(farthest)} away from the scan; give places near it.'
            )
        rough = Polyline(name, closed, color, nearest.points, np.zeros(len(places), dtype=np.bool_))
        [line] = prepared(found.rig, scan, [rough])
        [line] = with_errors(found.rig, scan.search(found.rig), scan.radii, [line])
    shapes = {"unit": found.unit, "shapes": [shape_document(line, found.metres_per_unit)]}
    return drawing_of(shapes).lines[0]


def _plan(fit: Fit, drawing: Drawn | None, tumours: Sequence[str], same_patient: bool) -> Plan:
    """The requested drawing, as a plan."""
    found = fit.in_metres
    circles = [tumour_text(short) for short in tumours]
    if drawing is None or isinstance(drawing, str):
        text = "+".join([*([] if drawing is None else [drawing]), *circles])
        return checked_plan(_document(_patterns(found.rig, text) if text else []))
    extra = _patterns(found.rig, "+".join(circles)) if circles else []
    if isinstance(drawing, Path):
        drawing = drawing_document(drawing)
    if isinstance(drawing, Line | Lesion):
        drawing = [drawing]
    if isinstance(drawing, Drawing):
        drawing = drawing.document
    if not isinstance(drawing, Mapping):
        return checked_plan(_document([*drawn_items(drawing, found), *extra]))
    check_whose(drawing, [found.result], same_patient)
    given = checked_plan(dict(drawing), found.unit)
    return given.model_copy(update={"items": [*given.items, *checked_plan(_document(extra)).items]})


def _document(items: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    return {"schema": PLAN_SCHEMA, "items": list(items)}


def _patterns(rig: Rig, text: str) -> list[dict[str, Any]]:
    """Items of a plan; BadDrawing for what no drawing is called."""
    asked = asked_drawing(rig, text)
    named: list[tuple[str, dict[str, Any]]] = [(each.name, {}) for each in asked.fixed]
    for name, pattern in asked.patterns:
        named.append((name, pattern.model_dump(exclude_unset=True)))  # type: ignore[attr-defined]  # all are pydantic's
    return [
        {"kind": "pattern", "id": f"pattern-{k}", "name": name, "parameters": parameters}
        for k, (name, parameters) in enumerate(named, 1)
    ]


def drawn_items(given: Sequence[Line | Lesion], fit: FitFolder) -> list[dict[str, Any]]:
    """Lines and lesions of a program as items of a plan, in mm.  Raises BadDrawing."""
    to_mm = 1e3 * fit.metres_per_unit
    items = []
    for number, each in enumerate(given, 1):
        if isinstance(each, Lesion):
            center = np.asarray(each.center, dtype=np.float64)
            if center.shape != (3,) or not np.isfinite(center).all():
                raise BadDrawing(f'The centre of "{each.name}" must be three finite numbers.')
            items.append(
                {"kind": "lesion", "name": each.name, "center": (to_mm * center).tolist(), "radius_mm": each.radius_mm}
            )
        else:
            [shape] = document_of([each])["shapes"]
            shape["points"] = (to_mm * np.asarray(shape["points"])).tolist()
            items.append({"kind": "line"} | shape)
        items[-1]["id"] = f"{items[-1]['kind']}-{number}"
    return items
