"""The JSON shapes of the surgeon's own drawing on a scan."""

from typing import Literal

from pydantic import Field

from breastrig.api.wire.common import Name, Point
from breastrig.api.wire.transfers import Colour, Given

SHAPES, POINTS, BYTES = 200, 20_000, 200_000  # of one drawing; a surgeon's has some ten lines of some hundred points


class OwnShape(Given):
    """One line, or with a single point one mark."""

    name: Name
    label: str = Field("", max_length=200)
    closed: bool = False
    color: Colour = "#101010"
    points: list[Point] = Field(
        min_length=1, max_length=POINTS, description="on the skin, millimetres in the scan's own frame"
    )


class OwnDrawing(Given):
    """Lines that were drawn on a scan; fields of other drawing files are passed over and not kept."""

    schema_: Literal["breastrig/drawing@1"] = Field("breastrig/drawing@1", alias="schema")
    unit: Literal["mm"] = "mm"
    shapes: list[OwnShape] = Field(max_length=SHAPES)
