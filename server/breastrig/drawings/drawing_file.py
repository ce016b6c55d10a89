"""A drawing that somebody else made (breastrig/drawing@1): polylines on a scan, or on the model.

The file may come from the page, from another program or from a person with an editor; what is wrong with it is one
sentence.
"""

import json
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from breastrig.core.arrays import Array, Booleans
from breastrig.core.errors import BadDrawing
from breastrig.core.units import BEYOND, METRES_PER_UNIT
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rig.model import DrawnShape, Rig

SHAPES, POINTS = 500, 50_000  # in one drawing; a surgeon's has some ten lines of some hundred points
UNIT_SUM, OUTSIDE = 1e-3, 1e-6  # of barycentric weights: files round them


@dataclass(frozen=True, eq=False)
class ScanShape:
    """A polyline on a scan."""

    name: str
    closed: bool
    color: str  # "#rrggbb"
    points: Array  # (M, 3) m, in the scan's frame
    bridged: Booleans  # (M,) not on the scan's skin, which has a hole there


@dataclass(frozen=True, eq=False)
class GivenDrawing:
    """A file's shapes; those on a scan and those on the model."""

    name: str
    on_scan: tuple[ScanShape, ...]
    on_model: tuple[DrawnShape, ...]


class _Part(BaseModel):
    model_config = ConfigDict(extra="ignore", frozen=True)


_Coordinate = Annotated[FiniteFloat, Field(ge=-BEYOND, le=BEYOND)]


class _SurfacePoint(_Part):
    face: int = Field(ge=0)
    barycentric: list[FiniteFloat] = Field(min_length=3, max_length=3)


class _Shape(_Part):
    name: str = Field(min_length=1, max_length=100)
    label: str = Field("", max_length=200)
    closed: bool = False
    color: str = Field("#101010", pattern=r"^#[0-9a-fA-F]{6}$")
    points: list[tuple[_Coordinate, _Coordinate, _Coordinate]] | None = None
    bridged: list[bool] | None = None
    surface_points: list[_SurfacePoint] | None = None


class _File(_Part):
    schema_: Literal["breastrig/drawing@1"] = Field("breastrig/drawing@1", alias="schema")
    name: str | None = Field(None, max_length=100)
    unit: Literal["m", "dm", "cm", "mm", "in"] | None = None
    shapes: list[_Shape] = Field(max_length=SHAPES)


def parsed_drawing(content: bytes | dict[str, Any], rig: Rig, unit: str) -> GivenDrawing:
    """The drawing of a file's bytes or document; `unit` is the scan's, for a file that names none.

    Raises BadDrawing for what is no drawing, is empty, or lies on another model.
    """
    try:
        document = json.loads(content) if isinstance(content, bytes) else content
        found = _File.model_validate(document)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(map(str, first["loc"])) or "the whole"
        raise BadDrawing(f"This is no drawing of the form breastrig/drawing@1 ({where}: {first['msg']}).") from error
    except (ValueError, RecursionError) as error:
        raise BadDrawing("This drawing is not JSON; give a file such as drawing.json that a fit leaves.") from error
    sizes = [len(shape.points or shape.surface_points or ()) for shape in found.shapes]
    if not sum(sizes):
        raise BadDrawing("This drawing is empty; draw at least one line or point first.")
    if sum(sizes) > POINTS:
        raise BadDrawing(f"This drawing has {sum(sizes)} points; at most {POINTS} can be carried.")
    names = [shape.name for shape in found.shapes]
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise BadDrawing(f'Two shapes of this drawing are called "{twice[0]}"; give each a name of its own.')
    per_unit = METRES_PER_UNIT[found.unit or unit]
    return GivenDrawing(
        found.name or "drawing",
        tuple(_on_scan(shape, per_unit) for shape in found.shapes if shape.points),
        tuple(_on_model(shape, rig) for shape in found.shapes if shape.surface_points and not shape.points),
    )


def _on_scan(shape: _Shape, per_unit: float) -> ScanShape:
    points = per_unit * np.array(shape.points, dtype=np.float64)
    bridged = np.zeros(len(points), dtype=np.bool_)
    if shape.bridged is not None:
        if len(shape.bridged) != len(points):
            raise BadDrawing(
                f'The shape "{shape.name}" has {len(points)} points but says of {len(shape.bridged)} whether they are '
                "bridged; say it of each or of none."
            )
        bridged[:] = shape.bridged
    return ScanShape(shape.name, shape.closed, shape.color, points, bridged)


def _on_model(shape: _Shape, rig: Rig) -> DrawnShape:
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
