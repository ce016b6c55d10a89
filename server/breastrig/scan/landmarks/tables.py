"""Reads tables of landmarks: CSV of spreadsheets and programs, and 3D Slicer's older .fcsv.

Columns are found by their names or, without a row of names, by their content: a name and three numbers, wherever they
are. Separators are commas, semicolons, tabs or spaces; decimals have points or commas.
"""

import csv
import re
import unicodedata
from typing import Any

from breastrig.core.errors import BadLandmarks
from breastrig.core.units import METRES_PER_UNIT

NUMBER = re.compile(r"[-+]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d+)?$")
UNIT = re.compile(r"[\[(_ ](" + "|".join(METRES_PER_UNIT) + r")[\])]?$")
AXIS_WORDS = ("pos", "position", "p", "coord", "coords", "coordinate", "koordinate", "wert", "value", "val", "axis")
AXES = {  # of a column's name, without its unit, spaces and signs: the axis, and its sign in the mesh's numbers
    **{f"{word}{axis}": (axis, 1.0) for axis in "xyz" for word in ("", *AXIS_WORDS)},
    **{f"{axis}{word}": (axis, 1.0) for axis in "xyz" for word in AXIS_WORDS},
    **{"l": ("x", 1.0), "p": ("y", 1.0), "s": ("z", 1.0), "r": ("x", -1.0), "a": ("y", -1.0)},  # Slicer's LPS, RAS
}
LABELS = (
    *("name", "label", "landmark", "landmarke", "bezeichnung", "nom", "punkt", "repere", "landmarkname", "point"),
    *("pointname", "title", "description", "desc", "id"),
)
FCSV = re.compile(r"^#\s*(?:markups fiducial file|columns\s*=)", re.IGNORECASE | re.MULTILINE)
SYSTEM = re.compile(r"^#\s*CoordinateSystem\s*=\s*(\S+)", re.IGNORECASE | re.MULTILINE)
COLUMNS = re.compile(r"^#\s*columns\s*=\s*(\S.*)$", re.IGNORECASE | re.MULTILINE)

PREAMBLE = 50  # lines before the table in which its row of names is looked for
ABSENT = 9999.0

UNCLEAR = (
    "Commas may part columns or decimals in this landmark file; save it with semicolons between columns, "
    "or with points before decimals."
)

Pairs = list[tuple[str, Any]]


def is_fcsv(text: str) -> bool:
    """Whether the remarks at its beginning are those of 3D Slicer."""
    return FCSV.search(text) is not None


def fcsv_landmarks(text: str) -> tuple[str, Pairs]:
    """(coordinate system as the file names it, names with cells)."""
    system, columns = SYSTEM.search(text), COLUMNS.search(text)
    names = (columns[1] if columns else "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label").split(",")
    plain = [name.strip().lower() for name in names]
    rows = _rows(_lines(text), ",")
    try:
        at = [plain.index(axis) for axis in "xyz"]
        label = plain.index("label")
        pairs: Pairs = [(row[label], [row[axis] for axis in at]) for row in rows]
    except (ValueError, IndexError) as error:
        raise BadLandmarks("This 3D Slicer .fcsv file is incomplete; save the point list again.") from error
    return system[1] if system else "RAS", pairs


def table_landmarks(text: str) -> tuple[Pairs, str | None] | None:
    """(names with three cells each, the unit that the columns name); None when it is no table."""
    lines = _without_preamble(_lines(text))
    separator = _separator(lines)
    if separator is None:
        return None
    rows = _rows(lines, separator)
    if separator == "," and any(_may_be_decimals(row) for row in rows):
        raise BadLandmarks(UNCLEAR)
    head = rows[0] if rows and sum(map(_is_number, rows[0])) < 3 and any(map(_axis, rows[0])) else None
    body = rows[1:] if head else rows
    columns = [_axis(cell) for cell in head or ()]
    axes = {found[0]: index for index, found in reversed(list(enumerate(columns))) if found is not None}
    if head is None or set(axes) != set("xyz"):
        return [_by_content(row, body) for row in body], None
    signs = [found[1] for axis in "xyz" if (found := columns[axes[axis]]) is not None]
    plain = [_plain(cell) for cell in head]
    label = next((plain.index(name) for name in LABELS if name in plain), None)
    if label is None:
        label = next((index for index in range(len(plain)) if index not in axes.values()), 0)
    units = {named[1] for axis in "xyz" if (named := UNIT.search(head[axes[axis]].strip().lower()))}
    placed = [row for row in body if not _is_unplaced(row, plain)]
    pairs: Pairs = []
    for row in placed:
        if len([cell for cell in row if cell]) > len(head):
            return [(row[0], row[1:])], None  # which says of this row that it needs three numbers
        cells = [row[axes[axis]] if axes[axis] < len(row) else "" for axis in "xyz"]
        pairs.append(
            (row[label] if label < len(row) else "", [_signed(*each) for each in zip(cells, signs, strict=True)])
        )
    return pairs, units.pop() if len(units) == 1 else None


def number(cell: Any) -> float:
    """The number in a cell, with decimal point or comma; ValueError or TypeError where it is none."""
    return float(cell.strip().replace("\u2212", "-").replace(",", ".") if isinstance(cell, str) else cell)


def _may_be_decimals(row: list[str]) -> bool:
    """Whether 1,5,2,5,3,5 may be three numbers with decimal commas: only whole ones, and too many."""
    found = [cell for cell in row if _is_number(cell)]
    return len(found) in (5, 6) and all(cell.lstrip("-+").isdigit() for cell in found)


def _signed(cell: str, sign: float) -> Any:
    return sign * number(cell) if _is_number(cell) else cell


def _is_number(cell: str) -> bool:
    return NUMBER.match(cell.replace("\u2212", "-")) is not None


def _plain(cell: str) -> str:
    plain = unicodedata.normalize("NFKD", cell.strip().strip('"').lower())
    return re.sub(r"[^a-z]", "", UNIT.sub("", plain))


def _axis(cell: str) -> tuple[str, float] | None:
    return AXES.get(_plain(cell))


def _is_unplaced(row: list[str], columns: list[str]) -> bool:
    """Whether Slicer's table says that the point was not placed."""
    at = columns.index("defined") if "defined" in columns else len(row)
    return at < len(row) and row[at].lower() in ("0", "false")


def _lines(text: str) -> list[str]:
    """The lines that are not empty, without remarks and without Excel's line that names the separator."""
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith(("#", "//", "%"))]
    return lines[1:] if lines and lines[0].strip().lower().strip('"').startswith("sep=") else lines


def _without_preamble(lines: list[str]) -> list[str]:
    """The lines from the row of column names, or from the first with separators; keeps all rows with numbers."""
    marks = (";", "\t", ",", None)
    for at, line in enumerate(lines[:PREAMBLE]):
        rows = [line.split(mark) for mark in marks]
        if set("xyz") in [{found[0] for cell in row if (found := _axis(cell)) is not None} for row in rows]:
            return lines[at:]
        counts = [sum(_is_number(cell.strip()) for cell in row) for row in rows]
        if max(counts[:-1]) >= 2 or counts[-1] >= 3:  # a date between spaces has fewer
            break
    mark = next((mark for mark in ";\t," if lines and lines[-1].count(mark) >= 3), None)
    first = next((at for at, line in enumerate(lines[:PREAMBLE]) if mark and mark in line), 0)
    return lines[first:]


def landmark_editor(text: str) -> Pairs | None:
    """Points of IDAV's Landmark Editor (.pts: a version, their number, then a name and a place a line), else None.

    Those that were not placed are 9999 along all axes.
    """
    lines = [line.split() for line in text.splitlines() if line.strip()]
    if len(lines) < 3 or [word.lower() for word in lines[0][:1]] != ["version"] or len(lines[1]) != 1:
        return None
    return [(row[0], row[1:4]) for row in lines[2:] if not _absent(row)]


def lddmm_landmarks(text: str) -> Pairs | None:
    """Points of an .lmk file (Landmarks-1.0: their number, then a name and a place in turns), else None."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    if not lines or not lines[0].lower().startswith("landmarks-"):
        return None
    rows = [(name, place.split()) for name, place in zip(lines[2::2], lines[3::2], strict=False)]
    return [(name, row[:3]) for name, row in rows if row[3:4] != ["0"]]


def _absent(row: list[str]) -> bool:
    return all(_is_number(cell) and abs(number(cell)) == ABSENT for cell in row[1:4])


def _separator(lines: list[str]) -> str | None:
    """The separator that all lines have, a space where commas are decimals; None where it is no table."""
    for mark in ";\t":
        if lines and all(mark in line for line in lines):
            return mark
    words = [line.split() for line in lines]
    numbers = [0 if any(word.strip(",") != word for word in row) else sum(map(_is_number, row)) for row in words]
    if lines and all(count >= 3 for count in numbers[1:] or numbers):
        return " "
    return "," if lines and "," in lines[0] else None


def _rows(lines: list[str], separator: str) -> list[list[str]]:
    """The filled rows' cells; between spaces the words of a name stay together."""
    if separator != " ":
        return [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=separator)]
    rows = []
    for line in lines:
        cells: list[str] = []
        for word in line.split():
            goes_on = bool(cells) and not _is_number(word) and not _is_number(cells[-1]) and _axis(word) is None
            cells[-1:] = [f"{cells[-1]} {word}"] if goes_on else [*cells[-1:], word]
        rows.append(cells)
    return rows


def _by_content(row: list[str], rows: list[list[str]]) -> tuple[str, list[str]]:
    """The name and the three numbers of a row without named columns."""
    texts = [index for index, cell in enumerate(row) if cell and not _is_number(cell)]
    numbers = [index for index, cell in enumerate(row) if _is_number(cell)]
    label = texts[0] if texts else 0
    if len(numbers) > 3:  # a number for each row is no place
        numbers = [index for index in numbers if not _counts(index, rows)] or numbers
    behind = [index for index in numbers if index > label]
    chosen = behind[:3] if len(behind) >= 3 else numbers[:3]
    if len(chosen) < 3:
        return row[0], row[1:]
    return row[label], [row[index] for index in chosen]


def _counts(column: int, rows: list[list[str]]) -> bool:
    cells = [row[column] if column < len(row) else "" for row in rows]
    return cells in ([str(k) for k in range(len(rows))], [str(k + 1) for k in range(len(rows))])
