"""The JSON shapes of patterns that follow a hand."""

from typing import Annotated, Literal

from pydantic import Field, FiniteFloat

from breastrig.api.wire.common import Name, Wire
from breastrig.drawings.drawing_schema import Colour, DrawnShape, LineUnit, Point

ParameterValue = FiniteFloat | Annotated[str, Field(max_length=20)]
Parameters = Annotated[dict[Annotated[str, Field(max_length=40)], ParameterValue], Field(max_length=20)]
Side = Literal["L", "R"]


class PatternDrag(Wire):
    """A handle of the pattern and the place to which it is dragged."""

    handle: Name = Field(description="name of the handle")
    to: Point = Field(description="mm in the scan's frame, on the body")


class PatternQuestion(Wire):
    name: Name = Field(description="reduction, vertical, periareolar, ellipse or tumour")
    parameters: Parameters = Field({}, description="as in a plan; what is missing has its default")
    side: Side | None = Field(None, description="that side alone; null: all of it")
    drag: PatternDrag | None = Field(
        None, description="the parameter of this handle becomes what brings it to that place; draws its side alone"
    )


class LengthsQuestion(Wire):
    places: list[Point] = Field(min_length=2, max_length=100, description="mm in the scan's frame, on the body")


class Leg(Wire):
    mm: float = Field(description="along the fitted skin, holes of the scan bridged: as measures are taken")
    points: list[Point] = Field(description="the shortest path, mm in the scan's frame")


class Lengths(Wire):
    legs: list[Leg] = Field(description="from each place to the next")


class PatternShape(DrawnShape):
    label: str
    closed: bool
    color: Colour
    bridged: list[bool] = Field(description="true where the scan has no skin to lie on")


class HandleNumber(Wire):
    """A parameter that the handle stands for."""

    parameter: str
    label: str
    unit: Literal["mm", "deg", "h"]
    value: float = Field(description="as it is now on this body")
    min: float | None
    max: float | None


class PatternHandle(Wire):
    """A place of the pattern that can be dragged."""

    name: str
    side: Side
    label: str
    at_mm: Point = Field(description="on the scan's skin, in its frame, mm")
    grows: list[float] = Field(description="unit vector: where to the first number grows; zeros: no one direction")
    numbers: list[HandleNumber]


class PatternOnScan(Wire):
    """The pattern as it is drawn on the fit's scan."""

    name: str
    parameters: Parameters = Field(description="as asked, or as dragged")
    unit: LineUnit = Field(description="of the points; the scan's")
    shapes: list[PatternShape]
    handles: list[PatternHandle]
    limit: str = Field(description="why the drag went no farther, in words; empty where it did not end")
    measured: dict[str, dict[str, float]] = Field(
        {}, description="each number as the drawn lines measure it, by parameter and side; empty for a drag"
    )
