"""Whether lines lie on the skin of one scan, before they are kept.

It reads the whole scan, so the service runs it in a process of its own, where the skin stays for the next lines.
"""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from breastrig.core.errors import BadInput
from breastrig.drawings.drawing_file import lines_on_scan
from breastrig.drawings.on_skin import check_on_skin
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.scan.read import read_scan


@dataclass(frozen=True)
class SkinJob:
    """Lines and places that are to be kept, which must lie on a scan's skin."""

    scan: Path
    file_type: str
    units: str
    shapes: tuple[dict[str, Any], ...]  # of breastrig/drawing@1, mm


def check_lines_on_skin(job: SkinJob) -> None:
    """Raises BadDrawing with a sentence for a line that lies off the skin as it was scanned, whatever is cut away."""
    try:
        skin = _skin(job.scan, job.file_type, job.units)
        for line in lines_on_scan({"unit": "mm", "shapes": list(job.shapes)}, "mm"):
            check_on_skin(line, skin.query(line.points).distances)
    except MemoryError as error:
        raise BadInput("Checking these lines needs more memory than it may use; give a smaller scan.") from error


@lru_cache(maxsize=1)
def _skin(scan: Path, file_type: str, units: str) -> ClosestPointSearch:
    read = read_scan(scan, file_type, units, texture=False, for_display=False)
    return ClosestPointSearch(read.vertices, read.faces)
