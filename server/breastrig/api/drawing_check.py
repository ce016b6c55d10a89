"""Whether lines that are sent lie where the scan is: else they are of another scan, or in another unit."""

from collections.abc import Sequence

from breastrig.api.beyond_scan import metres_outside, outside_text
from breastrig.core.errors import BadDrawing
from breastrig.storage.rows.scans import ScanRow

REACH_M = 0.05  # beyond the scan's bounds: a line may cross a hole at the rim, further out it is of another scan


def check_near_scan(name: str, points: Sequence[Sequence[float]], scan: ScanRow) -> None:
    """Raises BadDrawing with a sentence when one of the points (mm, scan frame) lies far outside."""
    for point in points:
        outside = metres_outside(point, scan)
        if outside > REACH_M:
            raise BadDrawing(
                f'A point of "{name}" lies {outside_text(outside)} outside of the scan; drawings are millimetres in '
                f"the scan's own frame, and this scan was read in {scan.facts['unit']}."
            )
