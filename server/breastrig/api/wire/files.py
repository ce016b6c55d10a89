"""The JSON shapes of the files that a fit leaves, as far as the API describes them."""

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from breastrig.api.wire.common import ModelSummary, StanceName, Three, VerdictLevel
from breastrig.workflow.events import DoubtedPick


class Document(BaseModel):
    """A file that another part of BreastRig writes; here only to describe it, so it may hold more."""

    model_config = ConfigDict(extra="allow")


class Distances(Document):
    mean: float | None
    std: float | None
    max: float | None
    p95: float | None


class SurfaceDistances(Distances):
    coverage: float = Field(description="share of the model's vertices with an accepted pair")


class LandmarkDistances(Document):
    mean: float | None
    std: float | None
    max: float | None
    min: float | None
    each: dict[str, float]


class ResultScan(Document):
    vertices: int
    triangles: int = Field(description="of the file, with what was cut away")
    cut_by_hand_triangles: int | None = Field(None, description="of these, cut away by a person; absent without any")
    unit: str
    sha256: str


class ResultBone(Document):
    name: str
    rotation_xyzw: list[float]
    translation_m: list[float]
    scale: list[float]


class ResultParameters(Document):
    bones: list[ResultBone]
    blendshapes: dict[str, float]


class Verdict(Document):
    level: VerdictLevel
    reasons: list[str] = Field(description="one sentence each, the strongest first; none when it is good")


class ModelAlone(Document):
    """The distances without the free-form layer: those of the rig as its bones and shapes have it."""

    surface_distance_mm: SurfaceDistances
    scan_to_model_mm: Distances
    landmark_distance_mm: LandmarkDistances


class MedianPlane(Document):
    """Points p with normal · p = offset, in the scan's unit and frame."""

    normal: list[float] = Field(description="unit vector to the patient's left")
    offset: float


class ResultFile(Document):
    """result.json; also the `result` of a done event."""

    schema_: Literal["breastrig/result@1"] = Field(alias="schema")
    scan: ResultScan
    model: ModelSummary
    stance: StanceName
    stance_reason: str
    preset: str
    refined: bool = Field(description="whether surface, drawing and distances are those of the free-form layer")
    verdict: Verdict | None = Field(None, description="whether to trust the fit; null in results of versions before")
    converged: bool
    stop_reason: str
    iterations: int
    timing_s: dict[str, float]
    surface_distance_mm: SurfaceDistances
    scan_to_model_mm: Distances
    landmark_distance_mm: LandmarkDistances
    model_alone: ModelAlone | None = Field(
        None, description="the distances without the free-form layer; null in results of versions before"
    )
    landmarks_not_followed: list[DoubtedPick] = Field([], description="picks that cannot be right, by name")
    landmarks_unusual: list[DoubtedPick] = Field([], description="picks that were followed and should be looked at")
    not_calibrated: str | None = Field(
        None, description="why there are no radii, and uncertainty.bin is all nan; null where they are known"
    )
    median_plane: MedianPlane | None = Field(None, description="of the fitted body; null in results of versions before")
    landmark_uncertainty_mm: dict[str, float] = Field(
        {}, description="radius that holds the landmark's true place with 90 %, by name; of a fit of this version"
    )
    line_error_mm: float | None = Field(
        None, description="radius that holds nine of ten places of lines on the breasts; null where it is not known"
    )
    landmarks_agreed: list[str] = Field([], description="names of those that were proposed and only agreed to")
    landmarks: dict[str, Three] = Field(
        description="of the fitted model, or where the scan's colours show them (landmarks_seen), in the scan's frame "
        "and unit"
    )
    landmarks_seen: dict[str, str] = Field(
        {}, description="what shows each landmark that the scan's colours place, by name; none where any was picked"
    )
    landmarks_picked: dict[str, Three] = Field({}, description="as given, in the scan's frame and unit")
    parameters: ResultParameters
    drawing_missing: list[str] = Field(
        [], description="why a pattern that was asked for is not in the drawing, a sentence or two for each"
    )
    notes: list[str]
    versions: dict[str, str]


class MeasuredStance(Document):
    """One fit of the report: its name there, and parts of its result.json."""

    name: str
    stance: StanceName
    preset: str
    verdict: Verdict | None = None
    scan: ResultScan
    surface_distance_mm: SurfaceDistances
    scan_to_model_mm: Distances
    landmark_distance_mm: LandmarkDistances
    model_alone: ModelAlone | None = None
    notes: list[str]


class MeasuredLines(Document):
    """The lines that a measure is of, in the scan's frame, mm: sided, or one for both."""

    left: list[Three] | None = None
    right: list[Three] | None = None
    value: list[Three] | None = None


class Measure(Document):
    """One measure of one stance, or its change from the first stance to the second; sided, or one value for both."""

    stance: str = Field(description="name of the stance; `second - first` for a change")
    measure: str = Field(description="name for programs")
    label: str = Field(description="for people")
    kind: str = Field(description="straight, along the skin, in height, ratio, volume, grade")
    unit: Literal["mm", "ml", "1", "grade"] = Field(
        description="grade: 0 none, 1 to 3 as Regnault's I to III, 4 glandular (pseudoptosis)"
    )
    left: float | None = Field(description="the patient's left")
    left_low: float | None = Field(description="low end of the band, where one is known")
    left_high: float | None
    right: float | None
    right_low: float | None
    right_high: float | None
    difference: float | None = Field(description="left less right; none of grades")
    value: float | None = Field(description="of a measure without sides")
    value_low: float | None = Field(description="low end of its band, where one is known")
    value_high: float | None = Field(description="high end of its band, where one is known")
    landmarks: str = Field(
        description="what it was measured between, each with its source: picked, seen by colour, or the model's"
    )
    method: str
    paths: MeasuredLines | None = Field(None, description="what was measured; null for a change between two stances")


class MeasuresFile(Document):
    """measures.json; what `breastrig report` writes as report.json."""

    schema_: Literal["breastrig/report@1"] = Field(alias="schema")
    notice: str
    breastrig: str = Field(description="version of the program")
    stances: list[MeasuredStance]
    doubts: list[str] = Field([], description="whether two stances are of one patient, a sentence each")
    signs: str = Field(description="how differences and changes are to be read")
    measures: list[Measure]
