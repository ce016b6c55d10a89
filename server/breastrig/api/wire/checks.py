"""The JSON shapes of the landmarks that a person should check."""

from typing import Annotated, Literal

from pydantic import Field

from breastrig.api.wire.common import Point, Wire

Fingers = Annotated[
    int,
    Field(ge=1, le=3, description="breadth of the band around the lines: 1 to 20 mm across (± 10), 2 to 40, 3 beyond"),
]


class ModelPoint(Wire):
    """A point on the model's surface."""

    face: int = Field(description="of the model's triangles")
    barycentric: Point = Field(description="weights of its corners")


class LandmarkCheck(Wire):
    """A landmark to look at."""

    name: str
    label: str
    side: Literal["L", "R"] | None = Field(description="the patient's; null on the midline")
    place: Point = Field(description="mm, in the scan's frame, on its skin: where the landmark is expected")
    normal: Point = Field(description="unit vector out of the skin there")
    radius_mm: float = Field(description="holds the true place with 90 %")
    point: ModelPoint = Field(description="the landmark on the model")
    line_error_mm: float = Field(description="of the lines, expected after this check and those before")
    fingers: Fingers


class LineChecks(Wire):
    """How sure the lines on a scan are, and the landmarks whose check makes them surer."""

    lines: Literal["plan", "drawing", "breasts"] = Field(
        description="whose error it is: of the plan on this scan, of the fit's own drawing, of lines on the breasts"
    )
    line_error_mm: float | None = Field(description="line error (90 %), the largest of the lines; null: not known")
    fingers: Fingers | None
    expected_line_error_mm: float | None = Field(description="after all checks; null without any")
    expected_fingers: Fingers | None
    worth_it: bool = Field(description="whether the checks make the lines surer by at least one finger")
    checks: list[LandmarkCheck] = Field(
        description="at most three, in this order: each narrows the lines most after those before it"
    )
    reason: str | None = Field(description="why there are no checks, one sentence")
