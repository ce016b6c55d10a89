"""The JSON shapes of patients and their plans."""

from operator import not_
from typing import Annotated, Literal

from pydantic import Field

from breastrig.api.wire.common import FitState, LaidShape, Links, Name, Paged, PageQuery, Point, Wire
from breastrig.api.wire.transfers import MarksOfScan
from breastrig.core.stances import Stance
from breastrig.drawings.drawing_schema import LineUnit
from breastrig.drawings.plan_schema import ITEMS, PlanItem, ScanOfPlan
from breastrig.files.result import VerdictLevel

CODE = 60  # characters
PLAIN = r"^[^\x00-\x1f\x7f]*$"  # no control characters: not every database takes them
Code = Annotated[
    str, Field(max_length=CODE, pattern=PLAIN, description="a code of your own, never a name or date of birth")
]


class PatientQuery(PageQuery):
    search: str = Field("", max_length=CODE, pattern=PLAIN, description="a part of the code, in any case")
    sort: Literal["newest", "code", "deletion"] = Field(
        "newest", description="newest first; by code, numbers by their value; or whose first scan is deleted soonest"
    )
    after: str = Field("", max_length=240, pattern=PLAIN, description="as the link to the next page says")


class PatientChange(Wire):
    code: Code


class ScanOwner(Wire):
    patient: Name | None = Field(description="id of the patient whose scan it is; null: of a new one")
    again: bool = Field(False, strict=True, description="though the same file is a scan of that patient already")
    same_as: list[Name] = Field(
        [],
        max_length=100,
        description="ids of scans of that patient: a person has said that this one is too, though a plan has `asked`",
    )


class PatientFit(Wire):
    """The newest fit of a scan."""

    id: str
    state: FitState
    created_at: str = Field(description="ISO 8601, UTC")
    verdict: VerdictLevel | None = Field(description="whether to trust it; null before the end, and of versions before")
    line_error_mm: float | None = Field(description="90 % line error on the breasts; null: not known")


class PatientScan(Wire):
    id: str
    stance: Stance = Field(description="as fitted, else as the service proposes")
    created_at: str = Field(description="ISO 8601, UTC")
    delete_at: str | None = Field(description="ISO 8601, UTC: kept until then; null: until it is deleted by hand")
    kind: Literal["surface", "image"] = Field(description="image: the label map of an image")
    thumbnail: str = Field(description="address of a small picture, PNG")
    fit: PatientFit | None


class Planned(Wire):
    """What is planned, in short."""

    patterns: list[str] = Field(description="names")
    lines: int
    lesions: int = Field(description="with tumours given by the clock")


class PatientLinks(Links):
    self: Annotated[str, ""]
    plan: Annotated[str, "/plan"]


class Patient(Wire):
    """One patient with the scans, oldest first."""

    id: str
    code: str
    group: str | None = Field(description="that owns the patient; null: administrators alone see the patient")
    created_at: str = Field(description="ISO 8601, UTC")
    plan_version: int = Field(description="0 before anything was planned")
    planned: Planned
    scans: list[PatientScan]
    links: PatientLinks


class PatientPage(Paged):
    patients: list[Patient] = Field(description="in the order asked for")


class SamePatient(Wire):
    same_patient: bool = Field(False, description="it is this patient's, though it names another code and scan")


class StoredPlan(Wire):
    """breastrig/plan@1 as it is kept, with its version."""

    schema_: Literal["breastrig/plan@1"] = Field(alias="schema")
    unit: Literal["mm"]
    patient: str | None = Field(None, description="the patient's code")
    version: int = Field(description="grows with each change; 0 before the first, whose ETag is 0 too")
    whole: bool = Field(description="whether somebody has written the plan; false: fits' own drawings still count")
    scans: list[ScanOfPlan]
    items: list[PlanItem] = Field(max_length=ITEMS)


class PlannedShape(LaidShape):
    """A line of the plan on a scan."""

    item: str = Field(description="id of the plan's item")
    kind: Literal["line", "pattern", "tumour", "lesion", "note"]
    carried: bool = Field(description="whether it was made on another scan")
    depth_mm: float | None = Field(None, description="of a tumour, below the skin")
    mirrored: bool = Field(False, exclude_if=not_, description="the line of the other side, mirrored")


class LesionDistance(Wire):
    """The straight distance from the centre of a lesion to the nearest point of what is named."""

    kind: Literal["skin", "nipple", "chest_wall", "line"]
    to: str = Field(description="the landmark's or the shape's name")
    point: Point = Field(description="in the drawing's unit")
    mm: float
    low_mm: float | None = Field(description="with the high one the band that holds nine of ten; null where not known")
    high_mm: float | None
    seen: bool = Field(
        False, exclude_if=not_, description="of the chest wall: the scan's file names it, as its slices show it"
    )


Outline = list[Annotated[list[float], Field(min_length=2, max_length=2)]]


class LesionSlice(Wire):
    """A plane through the centre of a lesion, with the fitted skin that it cuts."""

    plane: Literal["axial", "sagittal", "coronal"]
    right: Point = Field(description="unit vector in the scan's frame: patient's left, or back where sagittal")
    up: Point = Field(description="unit vector in the scan's frame: cranial, or the patient's front where axial")
    outlines_mm: list[Outline] = Field(description="of the skin, from the centre to the right and up")
    wall_mm: list[Outline] = Field(description="of the chest wall, seen or estimated; empty where neither is")


class LesionClock(Wire):
    """Where a lesion lies in its breast, as radiology writes it."""

    side: Literal["L", "R"] = Field(description="of the nearer nipple")
    hour: float | None = Field(description="of its direction from the nipple, read facing the patient; null behind it")
    text: str = Field(description="with the distance from the nipple, straight")


class RadiologyCheck(Wire):
    """What was typed of a radiologist's report beside where the lesion lies."""

    agrees: bool | None = Field(description="by side and quadrant; null where nothing of it can be compared")
    text: str = Field(description="one sentence")


class PlannedLesion(Wire):
    """A ball inside the body, in the scan's frame."""

    id: str = Field(description="of the plan's item")
    name: str
    center: Point = Field(description="in the drawing's unit")
    radius_mm: float
    error_mm: float | None = Field(description="radius that holds the true centre with 90 %; null where not known")
    ellipsoid_mm: list[Point] | None = Field(
        description="semi-axes of the ellipsoid that holds the true centre with 90 %, three vectors in the scan's frame"
    )
    depth_mm: float = Field(description="of the centre below the fitted skin")
    seen: bool = Field(description="whether the scan shows the skin next to it; where not, depth is the model's guess")
    distances: list[LesionDistance] = Field(
        description="skin, nearer nipple, chest wall if known; lines and patterns, nearest first"
    )
    slices: list[LesionSlice]
    carried: bool = Field(description="whether it was given on another scan")
    clock: LesionClock | None = Field(None, description="null for a model without nipples")
    radiology: RadiologyCheck | None = Field(None, description="null where nothing was typed of a report")


class PlannedNote(Wire):
    item: str
    text: str
    at: str | None = Field(description="name of the shape that is its place; null for a note of the whole")


class InsteadItem(Wire):
    """A pattern that can be drawn on this patient, on all of its sides."""

    label: str = Field(description="a few words for a button")
    name: str = Field(description="of the pattern")
    parameters: dict[str, float | str]


class MissingItem(Wire):
    item: str
    reason: str
    instead: list[InsteadItem] = Field(
        [], exclude_if=not_, description="what can be drawn in the place of a pattern that does not fit"
    )


class CarriedFrom(Wire):
    scan: str
    fit: str


class AskedScan(Wire):
    scan: str
    says: str = Field(description="why, one sentence")


class PlanOnScan(Wire):
    """breastrig/drawing@1: the whole plan on the scan of one fit."""

    schema_: Literal["breastrig/drawing@1"] = Field(alias="schema")
    name: str
    unit: LineUnit = Field(description="of the scan")
    notice: str
    shapes: list[PlannedShape]
    lesions: list[PlannedLesion]
    notes: list[PlannedNote]
    missing: list[MissingItem] = Field(description="items that cannot be shown here, and why")
    predicted: bool = Field(False, exclude_if=not_, description="no scan shows this body")
    doubts: list[str] = Field(
        [], description="why other scans may be another patient's, or that they were not compared, a sentence each"
    )
    asked: list[AskedScan] = Field(
        [],
        description="the patient's scans that do not look like this one: nothing is carried from them until somebody "
        "says that they are one patient's (`same_as` of putScanPatient)",
    )
    marks: list[MarksOfScan] = Field(
        [], exclude_if=not_, description="of the scans that items were carried from; behind a share link none"
    )
    version: int = Field(description="of the plan")
    whole: bool = Field(description="whether somebody has written the plan; false: the fit's own drawing still counts")
    fit: str = Field(description="id; behind a share link empty")
    patient: str | None = Field(
        None, description="the patient's code; behind a share link none", exclude_if=lambda code: code is None
    )
    scan_sha256: str | None = Field(
        None, description="of the scan's file; behind a share link none", exclude_if=lambda digest: digest is None
    )
    carried_from: list[CarriedFrom] = Field(
        description="fits of the patient's other scans that were used; behind a share link none"
    )
