"""Drawing files (breastrig/drawing@1) read into polylines on a scan or lines on the model, and written again.

A file may come from the page, from another program or from a person with an editor; what is wrong with it is one
sentence.  Which fields it may have and their limits are in drawing_schema.py.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from pydantic import ValidationError

from breastrig.core.arrays import Array
from breastrig.core.errors import BadDrawing, TooLarge
from breastrig.core.private_files import read_ordinary, shown
from breastrig.core.units import METRES_PER_UNIT
from breastrig.drawings.drawing_schema import GivenDrawing, GivenShape, ReadDrawing
from breastrig.drawings.line_error import drawn_error
from breastrig.geometry.polyline import Polyline
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rig.model import DrawnShape, Rig

FILE_BYTES = 400_000_000  # largest drawing file: as a scan; one that a fit leaves has some thirty thousand
Form = TypeVar("Form", GivenDrawing, ReadDrawing)
UNIT_SUM, OUTSIDE = 1e-3, 1e-6  # of barycentric weights: files round them


@dataclass(frozen=True, eq=False)
class Drawing:
    """A file's shapes; those on a scan, in its frame, and those on the model."""

    name: str
    on_scan: tuple[Polyline, ...]
    on_model: tuple[DrawnShape, ...]


def checked_drawing(content: bytes | dict[str, Any]) -> GivenDrawing:
    """The checked fields of an untrusted drawing. Raises BadDrawing for what is no drawing, and beyond the limits."""
    return _checked(GivenDrawing, content)


def _checked(form: type[Form], content: bytes | dict[str, Any]) -> Form:
    """The fields of a file's bytes or document.  Raises BadDrawing for what is no drawing."""
    try:
        document = json.loads(content) if isinstance(content, bytes) else content
        return form.model_validate(document)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(map(str, first["loc"])) or "the whole"
        raise BadDrawing(f"This is no drawing of the form breastrig/drawing@1 ({where}: {first['msg']}).") from error
    except (ValueError, RecursionError) as error:
        raise BadDrawing("This drawing is not JSON; give a file such as drawing.json that a fit leaves.") from error


def parsed_drawing(content: bytes | dict[str, Any], rig: Rig, unit: str) -> Drawing:
    """The drawing of a file's bytes or document; `unit` is the scan's, for a file that names none.

    Raises BadDrawing for what is no drawing, is empty, or lies on another model.
    """
    found = checked_drawing(content)
    if not any(shape.size for shape in found.shapes):
        raise BadDrawing("This drawing is empty; draw at least one line or point first.")
    return Drawing(
        found.name or "drawing",
        _on_scan(found, unit),
        tuple(_on_model(shape, rig) for shape in found.shapes if shape.surface_points and not shape.points),
    )


def lines_on_scan(content: bytes | dict[str, Any], unit: str) -> tuple[Polyline, ...]:
    """The polylines of a fit's drawing, perhaps none; BadDrawing where a shape is not on the scan."""
    found = _checked(ReadDrawing, content)
    elsewhere = next((shape.name for shape in found.shapes if not shape.points), None)
    if elsewhere is not None:
        raise BadDrawing(f'The shape "{elsewhere}" has no points on the scan; give the drawing.json of a fit.')
    return _on_scan(found, unit)


def planned_on_scan(document: dict[str, Any]) -> tuple[Polyline, ...]:
    """The polylines of a plan on a scan as `plan_document` writes it, in metres."""
    return _on_scan(ReadDrawing.model_validate(document), "mm")


def lesions_on_scan(document: Mapping[str, Any]) -> tuple[tuple[dict[str, Any], Array, float], ...]:
    """(lesion as `plan_document` writes it, (3,) m centre, m radius) of a plan on a scan."""
    per_unit = METRES_PER_UNIT[document["unit"]]
    lesions = document.get("lesions", [])
    return tuple((each, per_unit * np.array(each["center"]), 1e-3 * each["radius_mm"]) for each in lesions)


def shape_document(line: Polyline, metres_per_unit: float) -> dict[str, Any]:
    """The line as a shape of a drawing file in this unit; unknown fields are left out."""
    document: dict[str, Any] = {
        "name": line.name,
        "closed": line.closed,
        "color": line.color,
        "points": [[round(float(value), 6) for value in point] for point in line.points / metres_per_unit],
        "bridged": line.bridged.tolist(),
    }
    if line.error is not None and np.isfinite(line.error).any():
        document["error_mm"] = millimetres(line.error)
        document["line_error_mm"] = rounded_mm(drawn_error([line]))
    return document


def rounded_mm(length: float | None) -> float | None:
    """A length in m rounded to a tenth of a millimetre, as line errors are."""
    return None if length is None else round(1e3 * length, 1)


def millimetres(lengths: Array) -> list[float | None]:
    """(M,) m in millimetres; null for what is not finite."""
    return [round(1e3 * float(value), 3) if np.isfinite(value) else None for value in lengths]


def _on_scan(drawing: GivenDrawing | ReadDrawing, unit: str) -> tuple[Polyline, ...]:
    per_unit = METRES_PER_UNIT[drawing.unit or unit]
    return tuple(_polyline(shape, per_unit) for shape in drawing.shapes if shape.points)


def _polyline(shape: GivenShape, per_unit: float) -> Polyline:
    points = per_unit * np.array(shape.points, dtype=np.float64)
    bridged = np.array(shape.bridged) if shape.bridged else np.zeros(len(points), dtype=np.bool_)
    error = 1e-3 * np.array(shape.error_mm, dtype=np.float64) if shape.error_mm else None  # null becomes nan
    return Polyline(shape.name, shape.closed, shape.color, points, bridged, error=error)


def _on_model(shape: GivenShape, rig: Rig) -> DrawnShape:
    assert shape.surface_points is not None
    faces = np.array([point.face for point in shape.surface_points], dtype=np.int64)
    weights = np.array([point.barycentric for point in shape.surface_points])
    if faces.max() >= len(rig.faces):
        raise BadDrawing(
            f'The shape "{shape.name}" lies on triangle {faces.max()} of another model; this one ({rig.name}) has '
            f"{len(rig.faces)}: give the model that it was drawn on."
        )
    if (np.abs(weights.sum(axis=1) - 1.0) > UNIT_SUM).any() or weights.min() < -OUTSIDE:
        raise BadDrawing(
            f'The shape "{shape.name}" has a point outside its triangle; barycentric weights must be positive and '
            "sum to 1."
        )
    return DrawnShape(shape.name, shape.label or shape.name, shape.closed, shape.color, SurfacePoints(faces, weights))


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
