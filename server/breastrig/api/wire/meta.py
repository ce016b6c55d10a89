"""The JSON shapes of the service's description: version, limits, model, drawings, examples, health."""

from typing import Literal

from pydantic import Field

from breastrig.api.wire.common import LandmarkFile, Scan, Wire
from breastrig.api.wire.persons import Caller
from breastrig.core.stances import Stance
from breastrig.drawings.pattern_parameters import PatternInfo
from breastrig.files.result import ModelSummary


class ExampleEntry(Wire):
    name: str
    label: str
    stance: Stance


class Examples(Wire):
    examples: list[ExampleEntry]


class ExampleScan(Scan):
    example_landmarks: LandmarkFile = Field(description="the example's own picks; offered, not stored")


class Limits(Wire):
    upload_bytes: int
    zip_bytes: int = Field(description="of a zip of DICOM images")
    triangles: int
    keep_days: float | None = Field(description="scans are deleted so many days after their upload; null: never")


class ScanFiles(Wire):
    endings: list[str] = Field(
        description="of names, with their dots; a file without an ending, as on a PACS's media, is read too"
    )


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


class MetaQuery(Wire):
    model: str | None = Field(None, max_length=64, description="name of one of `models`; without it the first")


class Meta(Wire):
    name: Literal["BreastRig"]
    version: str
    notice: str
    limits: Limits
    scan_files: ScanFiles
    units: list[str]
    model: ModelSummary
    models: list[str] = Field(description="names of those that a scan can be uploaded for")
    landmarks: list[LandmarkInfo]
    presets: list[str]
    drawings: list[DrawingInfo] = Field(description="that need no parameters; patterns with all defaults among them")
    patterns: list[PatternInfo]
    person: Caller | None = Field(description="who asks; null where the service has no users")
    archives: list[str] = Field(description="names of those that results can be sent to; an administrator sets them")


class Health(Wire):
    status: Literal["ok"]


class Readiness(Wire):
    status: Literal["ready"]
