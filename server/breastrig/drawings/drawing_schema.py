"""The schema of drawing files (breastrig/drawing@1): fields, limits and consistency checks.

Files, requests and answers are all checked by these classes, so all of them accept the same. The limits are far beyond
a surgeon's drawing, which has some ten lines of some hundred points; a drawing written by a fit has none, for it may
contain a whole plan.
"""

from collections import Counter
from typing import Annotated, Literal, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, FiniteFloat, model_validator

from breastrig.core.errors import BadDrawing
from breastrig.core.identity import CODE_CHARACTERS
from breastrig.core.units import BEYOND

SHAPES, POINTS = 500, 50_000  # in one drawing; points of all its shapes together
NAME, LABEL = 100, 200  # characters, of a shape
TITLE = 1_000  # characters, of a drawing: a fit's is made of the names of all drawings that it was asked for
BLACK = "#101010"
SCHEMA: Literal["breastrig/drawing@1"] = "breastrig/drawing@1"

LineUnit = Literal["m", "dm", "cm", "mm", "in", "ft"]
Colour = Annotated[
    str,
    Field(pattern=r"^#[0-9a-fA-F]{6}$"),
    BeforeValidator(lambda color: BLACK if color is None else color),  # drawing.json may say that it has none
]
Coordinate = Annotated[FiniteFloat, Field(ge=-BEYOND, le=BEYOND)]
Point = Annotated[list[Coordinate], Field(min_length=3, max_length=3)]
Radius = Annotated[FiniteFloat, Field(ge=0, le=BEYOND)]
Title = Annotated[str, Field(max_length=TITLE)]
PatientCode = Annotated[str, Field(max_length=CODE_CHARACTERS)]
Digest = Annotated[str, Field(max_length=64)]

ON_THE_SKIN = "on the scan's skin, in its frame and the drawing's unit"
WHOSE = "the patient's code; another's drawing is asked about"
MADE_ON = "sha256 of the scan that it was made on"
IS_BRIDGED = "for each point whether it is not on the skin, because the scan has a hole there"
ERROR = "for each point the radius in millimetres that holds its true place with 90 %; null where it is not known"
LINE_ERROR = "line error (90 %), mm, measured across the line, as a fit's line_error_mm"


def _is_none(value: object) -> bool:
    return value is None


def _is_not_said(values: list[object] | None) -> bool:
    return not values


class Part(BaseModel):
    """A part of a drawing file from any program: unknown fields are ignored."""

    model_config = ConfigDict(extra="ignore", frozen=True, populate_by_name=True, defer_build=True)


class SurfacePoint(Part):
    """A place on the model."""

    face: int = Field(ge=0, le=2**31)
    barycentric: list[FiniteFloat] = Field(min_length=3, max_length=3)


class _Shape(Part):
    name: str = Field(min_length=1, max_length=NAME)
    label: str = Field("", max_length=LABEL)
    closed: bool = False
    color: Colour = BLACK


class DrawnShape(_Shape):
    """One polyline on a scan; a single point is one too."""

    points: list[Point] = Field(min_length=1, description=ON_THE_SKIN)
    bridged: list[bool] | None = Field(None, description=IS_BRIDGED, exclude_if=_is_not_said)
    error_mm: list[Radius | None] | None = Field(None, description=ERROR, exclude_if=_is_not_said)
    line_error_mm: Radius | None = Field(None, description=LINE_ERROR, exclude_if=_is_none)

    @model_validator(mode="after")
    def _says_it_of_each_point(self) -> Self:
        _check_lengths(self.name, len(self.points), self.bridged, self.error_mm)
        return self


class GivenShape(_Shape):
    """One polyline in an input: on a scan, or on the model."""

    points: list[Point] | None = Field(None, description=ON_THE_SKIN)
    bridged: list[bool] | None = Field(None, description=IS_BRIDGED)
    error_mm: list[Radius | None] | None = Field(None, description=ERROR)
    surface_points: list[SurfacePoint] | None = Field(None, description="instead of points: places on the model")

    @model_validator(mode="after")
    def _says_it_of_each_point(self) -> Self:
        if self.points:
            _check_lengths(self.name, len(self.points), self.bridged, self.error_mm)
        return self

    @property
    def size(self) -> int:
        """The number of its points, on a scan or on the model."""
        return len(self.points or self.surface_points or ())


class DrawingFile(Part):
    """Polylines on a scan: drawing.json."""

    schema_: Literal["breastrig/drawing@1"] = Field(alias="schema")
    name: Title | None = None
    unit: LineUnit = Field(description="of the points; the scan's")
    patient: PatientCode | None = Field(None, description=WHOSE, exclude_if=_is_none)
    scan_sha256: Digest | None = Field(None, description=MADE_ON, exclude_if=_is_none)
    shapes: list[DrawnShape]


class OwnDrawing(Part):
    """Lines drawn on a scan; fields of other drawing files are ignored and not kept."""

    schema_: Literal["breastrig/drawing@1"] = Field(SCHEMA, alias="schema")
    unit: Literal["mm"] = "mm"
    patient: PatientCode | None = Field(None, description=WHOSE, exclude_if=_is_none)
    scan_sha256: Digest | None = Field(None, description=MADE_ON, exclude_if=_is_none)
    shapes: list[DrawnShape] = Field(max_length=SHAPES)

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        _check_drawing([shape.name for shape in self.shapes], sum(len(shape.points) for shape in self.shapes))
        return self


class GivenDrawing(Part):
    """A drawing file as input."""

    schema_: Literal["breastrig/drawing@1"] = Field(SCHEMA, alias="schema")
    name: Title | None = None
    unit: LineUnit | None = Field(None, description="by default the scan's")
    patient: PatientCode | None = Field(None, description=WHOSE)
    scan_sha256: Digest | None = Field(None, description=MADE_ON)
    shapes: list[GivenShape] = Field(max_length=SHAPES)

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        _check_drawing([shape.name for shape in self.shapes], sum(shape.size for shape in self.shapes))
        return self


class ReadShape(GivenShape):
    """One polyline of a drawing written by this program, which may have lengthened its name."""

    name: str = Field(min_length=1)
    label: str = ""


class ReadDrawing(Part):
    """A drawing written by this program, with the lines of all items, however many."""

    schema_: Literal["breastrig/drawing@1"] = Field(SCHEMA, alias="schema")
    name: str | None = None
    unit: LineUnit | None = None
    shapes: list[ReadShape]


def _check_lengths(name: str, points: int, bridged: list[bool] | None, error_mm: list[float | None] | None) -> None:
    """Raises BadDrawing (which Pydantic passes on) where a list per point has another length than the points."""
    for given, field in ((bridged, "bridged"), (error_mm, "error_mm")):
        if given and len(given) != points:
            raise BadDrawing(
                f'The shape "{name}" has {points} points but {len(given)} of {field}; give one for each point or none.'
            )


def _check_drawing(names: list[str], points: int) -> None:
    """BadDrawing for too many points or for two shapes of one name."""
    if points > POINTS:
        raise BadDrawing(f"This drawing has {points} points; at most {POINTS} can be kept or carried.")
    twice = next((name for name, count in Counter(names).items() if count > 1), None)
    if twice is not None:
        raise BadDrawing(f'Two shapes of this drawing are called "{twice}"; give each a name of its own.')
