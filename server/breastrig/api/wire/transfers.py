"""The JSON shapes of transfers: a drawing made on the scan of one fit, shown on the scan of another."""

from typing import Literal

from pydantic import Field

from breastrig.api.wire.common import LaidShape, Name, Three, Wire
from breastrig.drawings.drawing_schema import Digest, GivenDrawing, LineUnit, PatientCode


class TransferRequest(Wire):
    from_fit: Name = Field(description="id of the fit of the scan that was drawn on")
    to_fit: Name = Field(description="id of the fit of the scan that shall show it")
    drawing: GivenDrawing | None = Field(None, description="null: the drawing that the first fit left")
    other_patient: bool = Field(
        False, strict=True, description="the scans are of two patients: the same place of the model, not the same skin"
    )
    same_patient: bool = Field(
        False,
        strict=True,
        description="all is one patient's, though the drawing names another code and scan, or the bodies differ",
    )


class MarksRequest(Wire):
    from_fit: Name = Field(description="id of the fit of one scan")
    to_fit: Name = Field(description="id of the fit of the other")
    same_patient: bool = Field(False, strict=True, description="both are one patient's, though the bodies differ")


class ProposedMark(Wire):
    name: str = Field(description="m1, m2, ...; no mark of either scan has it")
    kind: Literal["dot", "cross", "mole"] = Field(description="what it looks like on the first scan")
    source: Three = Field(description="mm, on the first scan, in its frame")
    target: Three = Field(description="mm, on the second, likewise")
    off_mm: float = Field(description="on the second scan, from where it was expected")
    error_mm: float = Field(description="90 % radius of what was expected")


class ProposedMarks(Wire):
    says: str = Field(description="how many small marks each scan shows and how many pairs there are, one sentence")
    marks: list[ProposedMark]


class CarriedShape(LaidShape):
    """A polyline on the second scan, and how well the fits lie on their scans there."""

    distance_from_mm: list[float | None] = Field(
        description="how far the first fit was from its scan there; null without skin"
    )
    distance_to_mm: list[float | None] = Field(
        description="how far the second fit was from its scan there; null without skin"
    )


class AskedMark(Wire):
    name: str
    says: str = Field(description="how far off it is, and a question")


class SharedMarks(Wire):
    """The marks of two scans of one patient."""

    followed: list[str] = Field(description="names of those on both scans that lines follow")
    asked: list[AskedMark] = Field(description="on both scans, contradicting all else; lines do not follow them")
    unpaired: list[str] = Field(description="names of those on one of the scans alone")


class MarksOfScan(SharedMarks):
    scan: str = Field(description="id of the other scan")


class CarriedDrawing(Wire):
    schema_: Literal["breastrig/drawing@1"] = Field(alias="schema")
    name: str
    unit: LineUnit = Field(description="of the second scan")
    notice: str
    patient: PatientCode | None = Field(None, exclude_if=lambda code: code is None)
    scan_sha256: Digest | None = Field(None, exclude_if=lambda digest: digest is None)
    doubts: list[str] = Field([], description="why the two scans may be of two patients, a sentence each")
    moved: list[str] = Field(
        [], description="which points lay off the first scan's skin, by more than 1 mm, and were moved onto it"
    )
    marks: SharedMarks | None = Field(
        None, exclude_if=lambda marks: marks is None, description="of both scans; absent without any"
    )
    carried_by: Literal["skin", "model"]
    shapes: list[CarriedShape]
