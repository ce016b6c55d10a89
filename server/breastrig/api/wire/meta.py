"""The JSON shapes of what the service says of itself: version, limits, model, drawings, examples, health."""

from typing import Literal

from pydantic import Field

from breastrig.api.wire.common import LandmarkFile, Scan, Wire
from breastrig.files.result import ModelSummary


class ExampleEntry(Wire):
    name: str
    label: str


class Examples(Wire):
    examples: list[ExampleEntry]


class ExampleScan(Scan):
    example_landmarks: LandmarkFile = Field(description="the example's own picks; offered, not stored")


class Limits(Wire):
    upload_bytes: int
    triangles: int
    keep_days: float | None = Field(description="scans are deleted so many days after their upload; null: never")


class LandmarkInfo(Wire):
    name: str
    label: str
    latin: str
    definition: str
    easy: bool = Field(description="easy to see on a scan without colour")
    mirror: str = Field(description="name of the landmark on the other side, its own when it lies in the middle")


class DrawingInfo(Wire):
    name: str
    label: str


class PatternParameter(Wire):
    """A number, or one of some choices."""

    name: str
    label: str
    about: str = Field(description="one sentence for people")
    unit: Literal["mm", "deg", "h", ""]
    default: float | str | None = Field(description="null: must be given, or when `needed` is false chosen by itself")
    needed: bool = Field(description="whether it must be given")
    min: float | None = Field(description="null for a choice and for a place")
    max: float | None
    choices: list[str] | None


class PatternInfo(Wire):
    """A drawing made from numbers: asked for as `name:parameter=value,parameter=value`."""

    name: str
    label: str
    parameters: list[PatternParameter]


class Meta(Wire):
    name: Literal["BreastRig"]
    version: str
    notice: str
    limits: Limits
    units: list[str]
    model: ModelSummary
    landmarks: list[LandmarkInfo]
    presets: list[str]
    drawings: list[DrawingInfo] = Field(description="that need no parameters; patterns with all defaults among them")
    patterns: list[PatternInfo]


class Health(Wire):
    status: Literal["ok"]


class Readiness(Wire):
    status: Literal["ready"]
