"""The JSON shapes that page, scripts and service share; the source of openapi.json and of the page's types.

Requests forbid unknown fields, so that a misspelt name is answered with a sentence and not ignored.
Landmarks are always millimetres in the scan's own frame; everything else in space is metres, and its name or
description says so.
"""

import re
from typing import Annotated, Any, Literal, Self
from urllib.parse import urlencode

from apiflask.fields import UploadFile
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from breastrig.core.stances import Stance as OneStance
from breastrig.drawings.drawing_schema import SCHEMA, SHAPES, Colour, DrawnShape, LineUnit, SurfacePoint
from breastrig.languages.catalogue import LANGUAGES
from breastrig.scan.true_size import IN_SIZE, LONGEST, Scale
from breastrig.scan.volumes.answers import MOST_CHARACTERS
from breastrig.use.steps.events import FitEvent, IterationNumbers, NodePose

Units = Literal["auto", "m", "dm", "cm", "mm", "in", "ft"]
StanceWish = Literal["auto", "standing", "supine", "prone"]
StanceName = OneStance
FitState = Literal["queued", "running", "done", "failed", "cancelled"]
Finite = Annotated[FiniteFloat, Field(strict=True)]  # neither true nor "1"
Point = Annotated[list[Finite], Field(min_length=3, max_length=3)]
Three = Annotated[list[float], Field(min_length=3, max_length=3)]
Number = Annotated[Finite, Field(ge=-1e9, le=1e9)]
Name = Annotated[str, Field(min_length=1, max_length=100)]

LONGEST_DRAWING = 1_000_000  # characters: a plan of 500 items with 20 parameters each has 0.9 million
UNITS: tuple[Units, ...] = ("auto", "m", "dm", "cm", "mm", "in", "ft")


CERTAIN = (
    "names of landmarks that are followed whatever all else says; by default those stored with the scan, "
    "or none where the request brings landmarks of its own"
)


MARKS = (
    "places on the skin of any name (moles, dots, ends of pen lines), in the unit, the scan's own frame; lines follow "
    "those that both scans have"
)


CONFIDENCE = (
    "0 to 1, of landmarks that were proposed and only agreed to, as the proposal says it: each keeps the proposal's "
    "error.  1 says that a person has looked closely; of a landmark that stands exactly where it was proposed, and of "
    "which nothing is said, the proposal's own is taken"
)
Confidence = Annotated[Finite, Field(ge=0, le=1)]


class Wire(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)

    @classmethod
    def of(cls, known: object, **more: Any) -> Self:
        """The object's fields of the same names, and more."""
        same = {name: getattr(known, name) for name in cls.model_fields if hasattr(known, name)}
        return cls.model_validate(same | more)


class Links(Wire):
    """Addresses; those below the thing's own place have what follows it in their annotation."""

    @classmethod
    def at(cls, place: str, **others: str | None) -> Self:
        """The addresses below a place, and others."""
        below = {name: place + end for name, field in cls.model_fields.items() for end in field.metadata}
        return cls.model_validate(below | others)


class Upload(Wire):
    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)


class Headers(BaseModel):
    model_config = ConfigDict(extra="ignore", frozen=True, populate_by_name=True)


class IfMatch(Headers):
    if_match: str | None = Field(
        None, alias="If-Match", description="the ETag (of cuts their digest, in quotes) of what was changed"
    )

    @property
    def tag(self) -> str | None:
        """The text within the quotes, without the language of the answer that had it."""
        given = None if self.if_match is None else self.if_match.strip().removeprefix("W/").strip('"')
        return given and re.sub(f"-({'|'.join(LANGUAGES)})$", "", given)


SamePlace = Literal["yes", "no"]
SAME_PLACE = (
    "whether lesions of another file lie where the image does, though the file does not say so: the `value` of a "
    "choice of the 422 answer's `question`"
)


GROUP = "of a new patient: the group that owns the patient, where the caller is in several"


class ScanUpload(Upload):
    file: UploadFile = Field(
        description="PLY, OBJ, STL, GLB, PCD, XYZ, USDZ, or a zip of one with its images; an MRI's label map; "
        "an MRI as a zip of DICOM files"
    )
    units: Units = Field("auto", description="unit of the file's numbers; auto decides from the size and says so")
    patient: str | None = Field(
        None, max_length=64, description="id of the patient whose scan it is; without it a new patient"
    )
    again: bool = Field(False, description="though the same file is a scan of that patient already")
    group: str | None = Field(None, max_length=60, description=GROUP)
    model: str | None = Field(
        None, max_length=64, description="name of the model that it is fitted with, of /api/meta; without it the first"
    )

    frame: str | None = Field(
        None,
        max_length=10,
        description="of a label map whose file does not say where it lies, or says it twice: the `value` of a choice "
        "of the 422 answer's `question` (sform, qform), or three letters that say where the voxels' axes grow to (RAS)",
    )
    segments: str | None = Field(
        None,
        max_length=MOST_CHARACTERS,
        description='of a label map, JSON: as what segments are to be taken, {"2": "lesion", "3": "tissue", "4": '
        '"unused"}; for others the file\'s codes and their form decide',
    )
    series: str | None = Field(
        None,
        max_length=64,
        description="of several in DICOM files: the `value` of a choice of the 422 answer's `question`",
    )
    same_place: SamePlace | None = Field(None, description=f"of segmentations in the zip of an image: {SAME_PLACE}")


class Segment(Wire):
    """A segment of a label map with how it is used."""

    number: int = Field(description="in the file")
    name: str = Field(description="Lesion 1, Tissue 2: none of the file's words")
    taken_as: Literal["lesion", "tissue", "unused"]
    why: str
    radius_mm: float | None = Field(None, description="of a lesion, of its largest part")
    label: str | None = Field(
        None,
        exclude_if=lambda found: found is None,
        description="the file's own words, in the answer to its upload alone: they may name a patient and are not kept",
    )


class LesionsUpload(Upload):
    file: UploadFile = Field(description="lesions drawn on the scan's image: NIfTI, NRRD, DICOM SEG or RTSTRUCT")
    frame: str | None = Field(None, max_length=10, description="as at the upload of a scan")
    segments: str | None = Field(None, max_length=MOST_CHARACTERS, description="as at the upload of a scan")
    same_place: SamePlace | None = Field(None, description=SAME_PLACE)


class TakenLesion(Wire):
    """A lesion of the file, as it is called in the plan."""

    name: str
    center: Three = Field(description="mm, the scan's own axes")
    radius_mm: float
    new: bool = Field(description="false: the plan has it already, and it was not added again")


class TakenLesions(Wire):
    lesions: list[TakenLesion]
    segments: list[Segment]
    notes: list[str] = Field(description="what reading found, one sentence each")


class Bounds(Wire):
    min: Three
    max: Three


class Frame(Wire):
    """The proposed orientation of the body in the scan's own axes, for the camera."""

    up: Three = Field(description="unit vector towards the head")
    front: Three = Field(description="unit vector towards the patient's front")
    confidence: float = Field(ge=0, le=1)
    reason: str


class Stance(Wire):
    proposed: StanceName
    reason: str


class ScanLinks(Links):
    self: Annotated[str, ""]
    mesh: Annotated[str, "/mesh.glb"]
    landmarks: Annotated[str, "/landmarks"]
    proposed: Annotated[str, "/landmarks/proposed"]
    cuts: Annotated[str, "/cuts"]
    ink: Annotated[str, "/ink"]
    drawing: Annotated[str, "/drawing"]
    fits: Annotated[str, "/fits"]
    patient: str
    plan: str
    volume: str | None = Field(None, description="of a scan that was made of an image")


class ScanImage(Wire):
    """The image that a scan was made of, as it is kept: one byte a voxel."""

    shape: Annotated[list[int], Field(min_length=3, max_length=3)] = Field(description="voxels along each index")
    to_scan: Annotated[list[Annotated[list[float], Field(min_length=4, max_length=4)]], Field(min_length=4)] = Field(
        max_length=4, description="4 x 4, row by row: from indices of a voxel's middle to mm of the scan's axes"
    )
    bytes: int


class CutPlane(Wire):
    """A floor or wall: nothing within 15 mm of it, or behind it, is the patient. Or a table under the patient."""

    normal: Three = Field(description="unit vector towards the patient")
    height_m: float = Field(description="along the normal, in the scan's own axes")


class ScanScale(Wire):
    """How the scan got its true size, which is that of all its places; absent where it has its file's."""

    factor: float = Field(description="from the size of the scan's file to the true one")
    between: list[str] = Field(description="two landmarks or marks; `one place` and `another` have no name")
    mm: float = Field(description="the straight way between them, as measured on the patient")
    measured_mm: float = Field(description="the same in the scan's file")
    ends: list[Three] = Field(description="both places, mm, in the scan's frame and true size")


class GivenLength(Wire):
    """A straight length that was measured on the patient, or on a ruler or printed tag in the scan."""

    start: Name | Point = Field(
        alias="from",
        description="a landmark or mark of the scan, or a place in mm, in the scan's frame and present size",
    )
    end: Name | Point = Field(alias="to", description="as `from`")
    length_mm: Finite = Field(gt=0.0, le=LONGEST)


class Scan(Wire):
    id: str
    patient: str = Field(description="id of the patient whose scan it is")
    patient_code: str = Field(description="the patient's code: a random one where none was given")
    sha256: str = Field(description="of the file, by which drawings and plans say what they were made on")
    unit: Literal["m", "dm", "cm", "mm", "in", "ft"] = Field(description="unit that the file was read in")
    unit_reason: str
    size_doubt: str = Field("", description="why the unit or the export may be wrong; empty for an ordinary size")
    size_known: bool = Field(
        default=True,
        description="false: its file is of an app without a scale, or names no unit; errors are larger until a length "
        "is given (putLength)",
    )
    vertices: int
    triangles: int
    body_triangles: int | None = Field(
        None, description="so many of the mesh, the first ones, are the body; missing in scans of an older version"
    )
    bounds_m: Bounds = Field(description="metres, the scan's own axes")
    size_m: Three | None = Field(None, description="width, height and depth of the body in its own axes, metres")
    colours: Literal["none", "vertex", "texture"]
    reconstructed_from_points: bool = Field(
        False, description="the file held points without triangles; the surface was made from them"
    )
    cut_away_cm2: int = Field(
        0, ge=0, description="area of floors, walls and other people's hands, which fits and measures do not see"
    )
    background: list[CutPlane] = Field(default=[], description="the floors and walls that were cut away")
    table: CutPlane | None = Field(None, description="under a lying patient; fits and measures do not see it")
    other_pieces: list[Three] = Field(
        default=[], description="a place, metres, on each piece beside the body that was cut away"
    )
    notes: list[str] = Field(description="what reading found, one sentence each")
    segments: list[Segment] = Field(default=[], description="of a label map")
    image: ScanImage | None = Field(None, description="that the scan was made of; null for a surface or label map")
    frame: Frame
    stance: Stance
    scale: ScanScale | None = Field(None, exclude_if=lambda found: found is None)
    created_at: str = Field(description="ISO 8601, UTC")
    model: str = Field(description="name of the model that it is fitted with")
    model_said: bool = Field(False, description="a person has said that this model is the right one (putScanModel)")
    links: ScanLinks


class ScanModel(Wire):
    model: Name = Field(description="name of the model that the scan was uploaded for")


class _Landmarks(Wire):
    schema_: Literal["breastrig/landmarks@1"] = Field(default="breastrig/landmarks@1", alias="schema")
    landmarks: dict[Name, Point] = Field(description="in the unit, the scan's own frame", max_length=200)
    certain: list[Name] = Field(
        default=[], max_length=200, description="names of landmarks that are followed whatever all else says"
    )
    confidence: dict[Name, Confidence] = Field(
        default={}, max_length=200, description=CONFIDENCE, exclude_if=lambda found: not found
    )


class LandmarkFile(_Landmarks):
    """The landmark file of the command line as well; answers are in mm."""

    unit: Literal["mm"] = "mm"
    marks: dict[Name, Point] = Field(default={}, max_length=200, description=MARKS, exclude_if=lambda found: not found)
    scale: float = Field(
        default=1.0,
        exclude_if=lambda found: found == 1.0,
        description="the scan's size in which the places are: times that of its file, by a length; absent: 1",
    )


class GivenLandmarkFile(_Landmarks):
    """The landmark file of the command line; without a unit of its own it is in mm."""

    unit: LineUnit = "mm"
    marks: dict[Name, Point] | None = Field(
        None, max_length=200, description=f"{MARKS}; null or left out: those stored with the scan stay"
    )
    scale: Scale | None = Field(None, description=IN_SIZE)


class LandmarkUpload(Upload):
    file: UploadFile = Field(description="JSON, CSV, MeshLab .pp, 3D Slicer .mrk.json, .fcsv, or Landmark Editor .pts")


class Cut(Wire):
    """A part of a scan that a person has cut away: the triangles whose middle lies within the lasso, however deep."""

    to_picture: Annotated[list[Number], Field(min_length=16, max_length=16)] = Field(
        description="4 x 4, column by column: from metres in the scan's axes to the picture in which it was drawn"
    )
    lasso: list[Annotated[list[Number], Field(min_length=2, max_length=2)]] = Field(
        min_length=3, max_length=300, description="its corners there, -1 to 1 across and up"
    )


class CutsFile(Wire):
    cuts: list[Cut] = Field(max_length=32, description="the first that was made first")


class Cuts(CutsFile):
    digest: str = Field(description="the same for the same cuts, empty without any; a fit says with which it was made")


class ProposedLandmark(Wire):
    point: Three = Field(description="millimetres, the scan's own frame")
    confidence: float = Field(ge=0, le=1, description="1 is sure; one half is about 10 mm off")
    on_scan: bool = Field(
        description="false where the scan shows skin near it only, as at a fold under a breast or beside the scan's end"
    )
    error_mm: float | None = Field(
        None, description="radius that holds the true place with 90 %; null where it is not known"
    )
    reason: str | None = Field(
        None, description="what shows it beside the form of the body, as: areola seen; null where nothing does"
    )


class ProposedLandmarks(Wire):
    unit: Literal["mm"] = "mm"
    landmarks: dict[str, ProposedLandmark]
    not_proposed: dict[str, str] = Field(description="names of the model's other landmarks, each with why, a sentence")


class InkShape(DrawnShape):
    """One stroke of a pen on the skin."""

    kind: Literal["line", "closed", "dashed", "cross", "arrow", "writing"] = Field(
        description="the first three are lines of a plan, the others marks beside it"
    )
    marker: Literal["violet", "black", "blue", "green", "red"]
    length_mm: float = Field(description="of ink, without gaps")
    dropped: bool = Field(False, description="a person has said that it is none of the plan")
    cut: bool = Field(False, description="it lies for the most part in what a person has cut out of the scan")


class InkChange(Wire):
    dropped: dict[Name, bool] = Field(
        max_length=SHAPES, description="by name, whether it is dropped; lines that are not named stay as they are"
    )


class Ink(Wire):
    """A drawing (breastrig/drawing@1): the lines that were found on the skin, the longest first."""

    schema_: Literal["breastrig/drawing@1"] = Field(SCHEMA, alias="schema")
    unit: Literal["mm"] = "mm"
    shapes: list[InkShape]


class FitRequest(Wire):
    """A request for a fit."""

    scan: Name = Field(description="id of the scan")
    stance: StanceWish = "auto"
    landmarks: dict[Name, Point] | None = Field(
        None, max_length=200, description="millimetres, the scan's own frame; by default those stored with the scan"
    )
    certain: list[Name] | None = Field(None, max_length=200, description=CERTAIN)
    confidence: dict[Name, Confidence] | None = Field(
        None, max_length=200, description=f"{CONFIDENCE}; by default those stored with the scan, as `certain`"
    )
    marks: dict[Name, Point] | None = Field(
        None, max_length=200, description="millimetres, the scan's own frame; by default those stored with the scan"
    )
    preset: Name = "default"
    drawing: Annotated[str, Field(min_length=1, max_length=LONGEST_DRAWING)] | None = Field(
        None,
        description="drawings of the model and patterns with parameters, joined by +; null for none: the plan "
        "of the patient is drawn on every fit without being asked for (plan.json)",
    )
    refine: bool = Field(
        True, strict=True, description="after the fit a smooth free-form layer follows the skin that the scan shows"
    )
    start_from: Name | None = Field(
        None,
        description="id of a fit of the same scan that is done: this one goes on from there, with its landmarks "
        "where they are now, in fewer iterations",
    )


class LaidShape(DrawnShape):
    """A polyline on a scan."""

    label: str = Field("", exclude_if=lambda label: not label)
    closed: bool
    color: Colour
    bridged: list[bool] = Field(description="true where the scan has no skin to lie on")


class PredictionRequest(Wire):
    """A stance that no scan shows."""

    stance: StanceName


class MovedLandmarks(Wire):
    """Picks of a finished fit, some of them elsewhere."""

    landmarks: dict[Name, Point] = Field(max_length=200, description="all of them; mm, the scan's own frame")


class MovedModel(Wire):
    """The model at moved landmarks."""

    nodes: list[NodePose]
    mean_distance_mm: float = Field(description="mean distance of matched model vertices to the scan")
    landmark_distance_mm: float | None = Field(description="mean over the picked landmarks")
    coverage: float = Field(description="share of the model's vertices with an accepted match")
    elapsed_s: float


class FitHeaders(Headers):
    idempotency_key: str | None = Field(
        None,
        alias="Idempotency-Key",
        description="1 to 255 visible ASCII characters; the same request with the same key starts no second fit",
    )


class FitLinks(Links):
    self: Annotated[str, ""]
    events: Annotated[str, "/events"]
    result: Annotated[str, "/result.json"]
    result_zip: Annotated[str, "/result.zip"]
    fitted_glb: Annotated[str, "/fitted.glb"]
    fitted_ply: Annotated[str, "/fitted.ply"]
    drawing: Annotated[str, "/drawing.json"]
    distances: Annotated[str, "/distances.bin"]
    uncertainty: Annotated[str, "/uncertainty.bin"]
    checks: Annotated[str, "/checks"]
    plan: Annotated[str, "/plan.json"]
    report: Annotated[str, "/report.pdf"]
    measures: Annotated[str, "/measures.json"]
    cancel: Annotated[str, "/cancel"]
    moved: Annotated[str, "/moved"]
    shares: Annotated[str, "/shares"]
    predictions: Annotated[str, "/predictions"]


class FitAccepted(Wire):
    id: str
    links: FitLinks
    cuts: str = Field(description="the digest of what is cut out of the scan")


class Fit(Wire):
    id: str
    scan: str
    state: FitState
    queue_position: int | None = Field(description="1 for the next to run; null when the fit does not wait")
    created_at: str = Field(description="ISO 8601, UTC")
    stance: StanceWish = Field(description="as asked for; once started, as decided")
    asked_stance: StanceWish = Field(description="as asked for")
    landmarks: dict[Name, Point] = Field(description="as asked for, mm; also those that were only agreed to")
    certain: list[str] = Field(description="of these, those that the fit follows whatever all else says")
    marks: dict[Name, Point] = Field({}, description="as asked for, mm", exclude_if=lambda found: not found)
    preset: str
    drawing: str | None
    refine: bool
    cuts: str = Field(description="the digest of what was cut out of the scan when this fit was asked for")
    start_from: str | None = Field(description="id of the fit that this one went on from")
    predicted_from: str | None = Field(description="of a prediction: id of the fit that it was made from")
    last_event: int = Field(description="number of the last stored event, 0 before the first")
    iterations: int = Field(description="number of iterated events so far")
    numbers: IterationNumbers | None = Field(description="of the last iteration")
    reason: str | None = Field(description="why it failed or was cancelled")
    links: FitLinks


class EventRecord(Wire):
    id: int = Field(description="number of the event, from 1; the stream's `id:`")
    event: FitEvent


class EventPage(Wire):
    events: list[EventRecord]
    state: FitState
    next: str | None = Field(description="address of the next events that are there already, null when these are all")


class EventQuery(Wire):
    after: int = Field(0, ge=0, le=2**31, description="send only events with a greater number")


class EventPageQuery(EventQuery):
    limit: int = Field(200, ge=1, le=1000, description="at most so many events")


class Paged(Wire):
    next: str | None = Field(description="address of the next page, null on the last")


class FitPage(Paged):
    fits: list[Fit] = Field(description="the newest first")


class ScanPage(Paged):
    scans: list[Scan] = Field(description="the newest first")


class Limited(Wire):
    limit: int = Field(50, ge=1, le=200, description="at most so many entries")

    def next_page(self, address: str, **place: object) -> str | None:
        """The query for the list's next page; None after the last one."""
        if None in place.values():
            return None
        return f"{address}?{urlencode({**self.model_dump(exclude_defaults=True), **place})}"


class ScanQuery(Limited):
    after: str | None = Field(
        None, pattern=r"^[0-9TZ:.-]{1,32}~[\w-]{1,32}$", description="as the link to the next page says"
    )


class PageQuery(Limited):
    before: int | None = Field(None, ge=0, le=2**31, description="as the link to the next page says")


class ModelDrawnShape(Wire):
    name: str
    label: str
    closed: bool
    color: str
    surface_points: list[SurfacePoint]


class ModelDrawing(Wire):
    name: str
    label: str
    shapes: list[ModelDrawnShape]


class ModelSide(BaseModel):
    """The model's side file with the drawings merged in; further fields as in the file."""

    model_config = ConfigDict(extra="allow")
    name: str
    shape_names: list[str] = Field(description="in the order of the mesh's morph targets")
    drawings: list[ModelDrawing]


class FieldError(Wire):
    field: str
    message: str


class ShownLesion(Wire):
    """A lesion as one answer would place it."""

    name: str
    side: Literal["L", "R", "middle"] = Field(description="of the patient")
    x: float = Field(description="across the volume, from -1 (the patient's right end) to 1 (the left end)")
    y: float = Field(description="along the volume, from 0 (the feet's end) to 1 (the head's end)")


class Choice(Wire):
    value: str = Field(description="to be sent")
    text: str
    lesions: list[ShownLesion] = []
    picture: str | None = Field(None, description="PNG as a data: address, as one who faces the patient sees it")


class Question(Wire):
    """A question that a person has to answer; the request is sent again with that field."""

    problem: str = Field(description="what the file does not say, without the choices")
    field: str = Field(description="name of the field that answers")
    choices: list[Choice]


class Problem(Wire):
    """RFC 9457 problem details."""

    type: str
    title: str
    status: int
    detail: str = Field(description="one sentence: what is wrong, what to do")
    errors: list[FieldError] | None = Field(None, description="each field that was refused")
    question: Question | None = Field(None, description="what the file does not say and a person knows")
