"""The measures of a fit, for programs: the same as in `breastrig report`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from breastrig.core.one_thread import one_thread
from breastrig.report.measures import measures
from breastrig.use.reports.report import stance_of
from breastrig.use.values.fit_result import Fit
from breastrig.use.values.model import Model


class Value(Protocol):
    """A number of the report, with or without its band."""

    @property
    def value(self) -> float: ...
    @property
    def low(self) -> float | None: ...
    @property
    def high(self) -> float | None: ...


@dataclass(frozen=True)
class Number:
    """One number, in its measure's unit, with the band that holds the true one where that is known."""

    value: float
    low: float | None
    high: float | None


@dataclass(frozen=True)
class Measure:
    """One measure, of each breast or of both together; sides are the patient's."""

    name: str
    label: str  # for people
    kind: str  # straight | along the skin | in height | ratio | volume | grade
    unit: str  # mm | ml | 1 | grade: 0 none, 1 to 3 as Regnault's I to III, 4 glandular
    left: Number | None
    right: Number | None
    value: Number | None  # where there is one for both sides
    landmarks: tuple[str, ...]  # what it is measured between, each with its source: picked, seen, or model
    method: str  # also why something is not seen
    not_seen: tuple[str, ...] = ()  # of left, right, value: None there, as the scan does not show that breast
    not_known: tuple[str, ...] = ()  # of these and difference: None there, as the band would say nothing
    vague: tuple[str, ...] = ()  # likewise: those less sure than a tenth of themselves, not known well enough
    difference_margin: float | None = None  # half the band of the difference: both sides share part of their errors

    @property
    def difference(self) -> float | None:
        """Left less right, in `unit`; grades are no numbers to be subtracted."""
        if self.left is None or self.right is None or self.unit == "grade" or "difference" in self.not_known:
            return None
        return self.left.value - self.right.value


def measure(fit: Fit | str | Path, model: Model = None) -> tuple[Measure, ...]:
    """Distances (mm), ratios, breast volumes (ml) and, standing, the grade of ptosis of a fit or of the folder of one.

    A grade needs a nipple that was picked or that the scan's colours show.
    They are in mm and ml whatever the scan's unit; `unit` says so.  Landmarks that were picked and not doubted count
    as they were picked, those that the scan's colours show as they are seen, the others as the fitted model has them.
    A breast of which the scan shows less than half has no numbers: None, with its side in `not_seen` and the reason in
    `method`.  `model` is that of a folder.  Raises BadInput.
    """
    found = (fit if isinstance(fit, Fit) else Fit.load(fit, model)).in_metres
    with one_thread():
        rows = measures(stance_of(found))

    def number(found: Value | None) -> Number | None:
        return None if found is None else Number(float(found.value), _float(found.low), _float(found.high))

    return tuple(
        Measure(
            name=row.measure,
            label=row.label,
            kind=row.kind,
            unit=row.unit,
            left=number(row.left),
            right=number(row.right),
            value=number(row.value),
            landmarks=row.landmarks,
            method=row.method,
            not_seen=row.not_seen,
            not_known=row.not_known,
            vague=row.vague,
            difference_margin=None if row.difference is None else _float(row.difference.margin),
        )
        for row in rows
    )


def _float(value: float | None) -> float | None:
    return None if value is None else float(value)
