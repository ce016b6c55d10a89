"""Lines that a surgeon drew on the skin: from a scan to a drawing in its own frame.

`find_ink_on_file` is the service's way in: it runs in a process of its own, as reading does, because the file and its
picture are untrusted; the picture is decoded there, once.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from breastrig.core.arrays import frozen
from breastrig.core.errors import BadScan, NeedsAnswer
from breastrig.core.one_thread import one_thread
from breastrig.drawings.drawing_file import shape_document
from breastrig.drawings.drawing_schema import SCHEMA
from breastrig.scan.read import read_scan
from breastrig.use.scan import Scan, existing
from breastrig.use.values.drawing import Drawing, Line

if TYPE_CHECKING:
    from breastrig.colour.ink.find_ink import InkLine as FoundLine


@dataclass(frozen=True, eq=False, repr=False)
class InkLine(Line):
    """One stroke of a pen: a `Line` and what is known of it."""

    kind: str = "line"  # line, closed, dashed: lines of a plan; cross, arrow, writing: marks beside it
    marker: str = "black"  # violet, black, blue, green, red
    length_mm: float = 0.0  # of ink, without gaps


@dataclass(frozen=True, eq=False)
class Ink(Drawing):
    """All strokes on one scan, longest first, in its unit and frame; `transfer` carries it."""

    strokes: tuple[InkLine, ...] = field(default=())  # the lines, with what is known of them


def find_ink(scan: Scan | str | Path, *, units: str = "auto") -> Ink:
    """Lines that were drawn with a marker on the skin, read from the scan's colours; perhaps none.

    Each line's `points` (M, 3) are on the skin, in the scan's unit and frame.  A scan that was read before needs its
    picture, as `read_scan` brings it.  `units` belongs to a path, as in `read_scan`.

    Raises BadScan, with one sentence, for a scan without colours or with colours too coarse for a pen's line.
    """
    from breastrig.colour.ink import find_ink as search  # scikit-image and SciPy's filters are for coloured scans only
    from breastrig.scan.piece import COLOURLESS

    if isinstance(scan, Scan):
        found, file = scan.in_metres, scan.file
    else:
        file = existing(scan)
        try:
            found = read_scan(file, None, units, for_display=False)
        except NeedsAnswer as error:  # of a label map alone, which has no colours whatever the answer
            raise BadScan(COLOURLESS) from error
    with one_thread():
        strokes = search.find_ink(found)
    document: dict[str, Any] = ink_document(strokes, found.unit, found.metres_per_unit)
    lines = tuple(
        InkLine(
            each.line.name,
            frozen(each.line.points / found.metres_per_unit),
            each.line.closed,
            each.line.color,
            each.line.bridged,
            kind=each.kind.value,
            marker=each.marker.name,
            length_mm=1e3 * each.length,
        )
        for each in strokes
    )
    return Ink(None, found.unit, lines, document, () if file is None else (file,), lines)


@dataclass(frozen=True)
class InkJob:
    """A scan to be searched for ink."""

    scan: Path
    file_type: str
    units: str


def find_ink_on_file(job: InkJob) -> dict[str, Any]:
    """The drawing, in mm, ready for JSON.  Raises a BreastRigError with a sentence."""
    from breastrig.colour.ink.find_ink import find_ink  # a quarter of a second, which no other task needs

    try:
        scan = read_scan(job.scan, job.file_type, job.units, for_display=False)
        return ink_document(find_ink(scan), "mm", 1e-3)
    except MemoryError as error:
        raise BadScan("Finding ink on this scan needs more memory than it may use; simplify it first.") from error


def ink_document(lines: Sequence["FoundLine"], unit: str, metres_per_unit: float) -> dict[str, Any]:
    """breastrig/drawing@1 in this unit; each shape says what it is, which marker drew it, and its length in mm."""
    shapes = [
        shape_document(each.line, metres_per_unit)
        | {"kind": each.kind.value, "marker": each.marker.name, "length_mm": round(1e3 * each.length, 1)}
        for each in lines
    ]
    return {"schema": SCHEMA, "unit": unit, "shapes": shapes}
