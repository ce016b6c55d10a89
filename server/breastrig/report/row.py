"""One row of the table of measures, as it stands in report.json, measures.csv and the PDF."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Value:
    """One number, in the row's unit, with its band where one is known."""

    value: float
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True)
class Row:
    """One measure of one stance; sided, or one value for both breasts."""

    measure: str  # name for programs
    label: str  # for people
    kind: str  # straight | along the skin | ratio | volume
    unit: str  # mm | ml | 1
    left: Value | None
    right: Value | None
    value: Value | None
    landmarks: tuple[str, ...]  # each with its source: picked, or the model's
    method: str

    @property
    def difference(self) -> float | None:
        """Left less right."""
        return None if self.left is None or self.right is None else self.left.value - self.right.value
