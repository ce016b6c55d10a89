"""A table as data, from which the CSV file and the summary are both made, so that their numbers are the same."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from breastrig.core.documents import csv_table

Cell = str | int | float | None


@dataclass(frozen=True)
class Column:
    """One column; numbers are shown with so many digits after the point."""

    name: str  # in the CSV file
    heading: str = ""  # in the summary
    digits: int = 2
    key: bool = False  # words, not numbers


@dataclass(frozen=True)
class Row:
    cells: tuple[Cell, ...]
    mean: bool = False
    note: str = ""  # why there are no numbers


@dataclass(frozen=True)
class Table:
    """Rows of one shape; `name` is the stem of its file."""

    name: str
    caption: str
    columns: tuple[Column, ...]
    rows: list[Row] = field(default_factory=list)

    def csv(self) -> bytes:
        """All rows, numbers with five significant digits, notes of failed fits in the last column."""
        names = [*(column.name for column in self.columns), "note"]
        return csv_table(names, [dict(zip(names, self._csv_cells(row), strict=True)) for row in self.rows])

    @staticmethod
    def _csv_cells(row: Row) -> list[object]:
        cells = [f"{cell:.5g}" if isinstance(cell, float) else cell for cell in row.cells]
        return [*cells, "mean" if row.mean else row.note]

    def shown(self, row: Row) -> list[tuple[str, bool]]:
        """(text, is a number) of each cell."""
        result = []
        for column, cell in zip(self.columns, row.cells, strict=True):
            if isinstance(cell, float):
                result.append((f"{cell:.{column.digits}f}", True))
            else:
                result.append(("–" if cell is None else str(cell), not column.key))
        return result


def mean(values: Iterable[float | None]) -> float | None:
    """The mean of what is known; None when nothing is."""
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else None


def mean_row(label: Sequence[Cell], rows: Sequence[Row]) -> Row:
    """The mean of the number columns after the label's; failed rows are left out."""
    good = [row.cells[len(label) :] for row in rows if not row.note]
    width = len(rows[0].cells) - len(label)
    numbers = [mean(_number(cells[k]) for cells in good) for k in range(width)]
    return Row((*label, *numbers), mean=True)


def _number(cell: Cell) -> float | None:
    return None if cell is None or isinstance(cell, str) else float(cell)
