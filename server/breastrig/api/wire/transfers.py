"""The JSON shapes of transfers: a drawing made on the scan of one fit, shown on the scan of another."""

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from breastrig.api.wire.common import Name, Point, SurfacePoint, Three, Wire

Colour = Annotated[str, Field(pattern=r"^#[0-9a-fA-F]{6}$")]
LineUnit = Literal["m", "dm", "cm", "mm", "in"]


class Given(Wire):
    """A part of a drawing file, which may be sent as it is: what a transfer does not need is passed over."""

    model_config = ConfigDict(extra="ignore", frozen=True, populate_by_name=True)


class GivenShape(Given):
    """One polyline; a single point is one too."""

    name: Name
    label: str = Field("", max_length=200)
    closed: bool = False
    color: Colour = "#101010"
    points: list[Point] | None = Field(
        None, max_length=50_000, description="on the first scan's skin, in its frame and the drawing's unit"
    )
    bridged: list[bool] | None = Field(None, max_length=50_000, description="true where the point is not on the skin")
    surface_points: list[SurfacePoint] | None = Field(
        None, max_length=50_000, description="instead of points: places on the model"
    )


class GivenDrawing(Given):
    schema_: Literal["breastrig/drawing@1"] = Field("breastrig/drawing@1", alias="schema")
    name: Name | None = None
    unit: LineUnit | None = Field(None, description="by default the first scan's")
    shapes: list[GivenShape] = Field(max_length=500)


class TransferRequest(Wire):
    from_fit: Name = Field(description="id of the fit of the scan that was drawn on")
    to_fit: Name = Field(description="id of the fit of the scan that shall show it")
    drawing: GivenDrawing | None = Field(None, description="null: the drawing that the first fit left")
    other_patient: bool = Field(
        False, strict=True, description="the scans are of two patients: the same place of the model, not the same skin"
    )


class CarriedShape(Wire):
    name: str
    closed: bool
    color: str
    points: list[Three] = Field(description="on the second scan, in its frame and unit")
    bridged: list[bool] = Field(description="true where the second scan has no skin to lie on")
    distance_from_mm: list[float | None] = Field(
        description="how far the first fit was from its scan there; null without skin"
    )
    distance_to_mm: list[float | None] = Field(
        description="how far the second fit was from its scan there; null without skin"
    )


class CarriedDrawing(Wire):
    schema_: Literal["breastrig/drawing@1"] = Field(alias="schema")
    name: str
    unit: LineUnit = Field(description="of the second scan")
    notice: str
    carried_by: Literal["skin", "model"]
    shapes: list[CarriedShape]
