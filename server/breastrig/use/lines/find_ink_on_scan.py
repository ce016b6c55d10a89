"""Ink found on one scan: from a scan to a drawing in its own frame.

`find_ink_on_file` is the service's way in: it runs in a process of its own, as reading does, because the file and its
picture are untrusted; the picture is decoded there, once.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from breastrig.core.errors import BadScan
from breastrig.drawings.drawing_file import shape_document
from breastrig.drawings.drawing_schema import SCHEMA
from breastrig.scan.read import read_scan

if TYPE_CHECKING:
    from breastrig.colour.ink.find_ink import InkLine


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


def ink_document(lines: Sequence["InkLine"], unit: str, metres_per_unit: float) -> dict[str, Any]:
    """breastrig/drawing@1 in this unit; each shape says what it is, which marker drew it, and its length in mm."""
    shapes = [
        shape_document(each.line, metres_per_unit)
        | {"kind": each.kind.value, "marker": each.marker.name, "length_mm": round(1e3 * each.length, 1)}
        for each in lines
    ]
    return {"schema": SCHEMA, "unit": unit, "shapes": shapes}
