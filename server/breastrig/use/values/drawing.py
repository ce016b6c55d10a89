"""Surgical drawings on a scan, as programs see them."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from breastrig.core.arrays import Array, Booleans, frozen
from breastrig.core.documents import json_bytes
from breastrig.core.errors import BadDrawing
from breastrig.core.output_files import all_or_nothing, single_file
from breastrig.core.private_files import write_private

BLACK = "#101010"


@dataclass(frozen=True, eq=False, repr=False)
class Line:
    """A polyline of M points on a scan's skin."""

    name: str
    points: Array  # (M, 3) in the scan's unit and frame
    closed: bool = False
    color: str = BLACK  # "#rrggbb"
    bridged: Booleans | None = None  # (M,) where the scan has a hole and the line goes over it; None: nowhere
    distance_from_mm: Array | None = None  # (M,) of a carried line: from its first scan to the model there; or nan
    distance_to_mm: Array | None = None  # (M,) and from the scan that it is on now to the model there
    error_mm: Array | None = None  # (M,) the radius that holds each point's true place with 90 %, nan where not known
    line_error_mm: float | None = None  # how far off nine of ten of its places are, measured across it; None: not known

    def __repr__(self) -> str:
        over = 0 if self.bridged is None else int(np.count_nonzero(self.bridged))
        return f"<Line {self.name}: {len(self.points)} points, {over} of them over holes>"


@dataclass(frozen=True, eq=False)
class Lesion:
    """A ball inside the body, in a scan's unit and frame; lengths in their names' unit.

    `Lesion(name, center, radius_mm)` is one to be drawn or carried; the rest is what `draw` and `transfer` say of it.
    """

    name: str
    center: Array  # (3,)
    radius_mm: float
    error_mm: float | None = None  # radius that holds its true centre with 90 %; 0 where given, None: not known
    ellipsoid_mm: Array | None = None  # (3, 3) semi-axes, a row each, of the ellipsoid that holds it with 90 %
    depth_mm: float = np.nan  # below the fitted skin
    seen: bool = False  # whether the scan shows the skin next to it; where not, its depth is the model's guess
    distances_mm: dict[str, tuple[float, float, float]] = field(default_factory=dict)  # skin, nipple_L, chest_wall,
    # lines: with a 90 % band, or nan
    clock: str = ""  # its place as radiology writes it: left, 2 o'clock, 45 mm from the nipple


@dataclass(frozen=True, eq=False)
class Drawing:
    """The lines on one scan and lesions in it, in its unit and frame."""

    name: str | None
    unit: str
    lines: tuple[Line, ...]
    document: dict[str, Any] = field(repr=False)  # breastrig/drawing@1
    inputs: tuple[Path, ...] = field(default=(), repr=False)  # files that it was made from; saving replaces none
    lesions: tuple[Lesion, ...] = field(default=(), kw_only=True)

    def save(self, file: str | Path, *, force: bool = False) -> None:
        """Writes drawing JSON (breastrig/drawing@1, which names its unit), for its owner only.

        A file that is there already is replaced with `force` only.  Raises BadInput.
        """
        with all_or_nothing(single_file(Path(file), self.inputs, force)) as folder:
            write_private(folder / Path(file).name, json_bytes(self.document))


class _Shape(BaseModel):
    model_config = ConfigDict(extra="ignore", defer_build=True)

    name: str
    closed: bool = False
    color: str | None = None
    points: list[Annotated[list[FiniteFloat], Field(min_length=3, max_length=3)]]
    bridged: list[bool] | None = None
    distance_from_mm: list[float | None] | None = None
    distance_to_mm: list[float | None] | None = None
    error_mm: list[float | None] | None = None
    line_error_mm: float | None = None


class _Distance(BaseModel):
    to: str
    mm: float
    low_mm: float | None
    high_mm: float | None


class _Clock(BaseModel):
    text: str


class _Lesion(BaseModel):
    model_config = ConfigDict(extra="ignore", defer_build=True)

    name: str
    center: Annotated[list[FiniteFloat], Field(min_length=3, max_length=3)]
    radius_mm: float
    error_mm: float | None
    ellipsoid_mm: list[list[float]] | None
    depth_mm: float
    seen: bool
    distances: list[_Distance]
    clock: _Clock | None = None


class _File(BaseModel):
    model_config = ConfigDict(extra="ignore", defer_build=True)

    name: str | None = None
    unit: Literal["m", "dm", "cm", "mm", "in", "ft"]
    shapes: list[_Shape]
    lesions: list[_Lesion] = []


def drawing_of(document: Any, inputs: tuple[Path, ...] = ()) -> Drawing:
    """The lines of a document whose shapes lie on a scan; BadDrawing when it is none."""
    try:
        found = _File.model_validate(document)
        lines = tuple(_line(shape) for shape in found.shapes)
    except ValidationError as error:
        where = ".".join(map(str, error.errors(include_url=False, include_input=False)[0]["loc"])) or "the whole"
        raise BadDrawing(f"This is no drawing on a scan ({where}); fit the scan again.") from error
    return Drawing(found.name, found.unit, lines, document, inputs, lesions=tuple(map(_lesion, found.lesions)))


def _line(shape: _Shape) -> Line:
    points = np.array(shape.points, dtype=np.float64).reshape(-1, 3)
    per_point = (shape.bridged, shape.distance_from_mm, shape.distance_to_mm, shape.error_mm)
    if any(values is not None and len(values) != len(points) for values in per_point):
        raise BadDrawing(f'"{shape.name[:60]}" does not say the same of each of its points; fit the scan again.')
    bridged = np.zeros(len(points), np.bool_) if shape.bridged is None else np.array(shape.bridged, np.bool_)
    return Line(
        shape.name,
        frozen(points),
        shape.closed,
        shape.color or BLACK,
        frozen(bridged, np.bool_),
        _distances(shape.distance_from_mm),
        _distances(shape.distance_to_mm),
        _distances(shape.error_mm),
        shape.line_error_mm,
    )


def _lesion(found: _Lesion) -> Lesion:
    bands = {each.to: (each.mm, _known(each.low_mm), _known(each.high_mm)) for each in found.distances}
    given = found.model_dump(exclude={"distances", "center", "ellipsoid_mm", "clock"})
    ellipsoid = None if found.ellipsoid_mm is None else frozen(found.ellipsoid_mm)
    clock = "" if found.clock is None else found.clock.text
    return Lesion(**given, center=frozen(found.center), ellipsoid_mm=ellipsoid, distances_mm=bands, clock=clock)


def _known(mm: float | None) -> float:
    return float("nan") if mm is None else mm


def _distances(values: list[float | None] | None) -> Array | None:
    return None if values is None else frozen([np.nan if value is None else value for value in values])


def document_of(lines: Sequence[Line]) -> dict[str, Any]:
    """breastrig/drawing@1 of a program's own lines, in the scan's unit; BadDrawing for what are no points."""
    shapes = []
    for line in lines:
        if not isinstance(line, Line):
            raise BadDrawing("A drawing of a program is made of lines; give breastrig.Line(name, points) for each.")
        try:
            points = np.asarray(line.points, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise BadDrawing(f'The points of "{line.name}" are no numbers; give an array (M, 3).') from error
        if points.ndim != 2 or points.shape[1] != 3:
            raise BadDrawing(f'The points of "{line.name}" have the shape {points.shape}; it must be (M, 3).')
        shape: dict[str, Any] = {"name": line.name, "closed": line.closed, "color": line.color}
        shape["points"] = points.tolist()
        if line.bridged is not None:
            shape["bridged"] = np.asarray(line.bridged, np.bool_).tolist()
        if line.error_mm is not None:
            shape["error_mm"] = [None if np.isnan(each) else float(each) for each in np.asarray(line.error_mm)]
        shapes.append(shape)
    return {"schema": "breastrig/drawing@1", "shapes": shapes}
