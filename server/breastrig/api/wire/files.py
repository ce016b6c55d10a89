"""The JSON shapes of the files that a fit leaves, as far as the API describes them."""

from typing import Literal

from pydantic import Field

from breastrig.api.wire.common import Three
from breastrig.core.stances import Stance
from breastrig.files.result import (
    Distances,
    Document,
    LandmarkDistances,
    ModelAlone,
    ResultScan,
    SurfaceDistances,
    Verdict,
)


class MeasuredStance(Document):
    """One fit of the report: its name there, and parts of its result.json."""

    name: str
    stance: Stance
    predicted: bool = Field(False, description="no scan shows it; the distances are those of the fit it comes from")
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
    difference_low: float | None = Field(None, description="low end of its band: both sides share part of their errors")
    difference_high: float | None = None
    value: float | None = Field(description="of a measure without sides")
    value_low: float | None = Field(description="low end of its band, where one is known")
    value_high: float | None = Field(description="high end of its band, where one is known")
    not_seen: str = Field(
        "", description="left, right, value: those that have no number, as the scan does not show that breast"
    )
    not_known: str = Field("", description="of these and difference: those whose band says nothing")
    vague: str = Field("", description="likewise: those less sure than a tenth of themselves")
    printed_step: float = Field(1.0, description="in which steps its numbers are shown, so that differences agree")
    said: dict[str, str] = Field(
        default={}, description="the numbers as printed, with their bands: by left, right, value, difference"
    )
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
