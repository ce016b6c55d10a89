"""The JSON shapes of visits."""

from typing import Any, Literal

from pydantic import Field

from breastrig.api.wire.common import Name, Wire
from breastrig.core.stances import Stance
from breastrig.files.result import VerdictLevel
from breastrig.use.cases.visits import LABEL


class GivenVisit(Wire):
    date: str | None = Field(max_length=20, description="ISO 8601, a day such as 2026-11-29; null: not known")
    label: str = Field("", max_length=LABEL, description="such as: before, in theatre, 6 weeks")


class ScanVisit(Wire):
    """When a scan was taken, as a person has said it."""

    scan: str
    date: str | None = Field(description="ISO 8601, a day; null: nobody has said it")
    label: str


class PatientVisits(Wire):
    scans: list[ScanVisit]


class _PictureQuery(Wire):
    drawn: str = Field("", max_length=32, description="any text: with another one no browser shows an earlier picture")


class PlotQuery(_PictureQuery):
    stance: Stance


class ChangeQuery(_PictureQuery):
    scan: Name
    with_: Name = Field(alias="with", description="the other scan; the order does not matter")


class AskedVisit(Wire):
    """A scan whose day is not known, in a stance of which there is another scan."""

    scan: str
    stance: Stance


class DatedScan(Wire):
    scan: str
    date: str
    label: str
    verdict: VerdictLevel | None
    days: int = Field(description="since the first visit")


class ChangeOfSide(Wire):
    """What the map says of one breast."""

    seen_share: float | None = Field(description="of its skin, that both scans show")
    half_band_mm: float | None = Field(description="within which nothing is said")
    said_share: float | None = Field(description="of the seen skin, that changed by more than its band")
    largest_mm: float | None = Field(description="change outwards; null: none is said")


class ChangeMap(Wire):
    untouched_spread_mm: float = Field(description="of the skin around the breasts")
    left: ChangeOfSide
    right: ChangeOfSide


class ChangeBetween(Wire):
    """The later of two visits less the earlier."""

    earlier: int = Field(description="of `visits`, from 0")
    later: int
    map: ChangeMap | None
    measures: list[dict[str, Any]] = Field(description="as those of measures.json")
    doubts: list[str]
    missing: str = Field("", description="why there is no map")


class VisitsOfStance(Wire):
    stance: Stance
    visits: list[DatedScan]
    plotted: list[list[str]] = Field(description="measure and kind of each panel of visits.svg")
    measures: list[dict[str, Any]] = Field(description="as those of measures.json, with the number of their `visit`")
    changes: list[ChangeBetween]


class VisitsFile(Wire):
    """What the dated scans of a patient say over time."""

    schema_: Literal["breastrig/visits@1"] = Field(alias="schema")
    notice: str
    breastrig: str
    published: list[dict[str, Any]] = Field(description="ranges of published series, as context")
    asked: list[AskedVisit]
    stances: list[VisitsOfStance]
