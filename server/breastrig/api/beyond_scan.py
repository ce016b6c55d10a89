"""How far a point that is sent lies outside of its scan: then it is of another scan, or in another unit."""

from collections.abc import Sequence

from breastrig.core.units import distance_text
from breastrig.storage.rows.scans import ScanRow


def metres_outside(point: Sequence[float], scan: ScanRow) -> float:
    """m from the scan's bounds to a point (mm, scan frame), along the worst axis; below zero inside."""
    low, high = scan.facts["bounds_m"]["min"], scan.facts["bounds_m"]["max"]
    return float(max(max(a - x / 1000, x / 1000 - b) for x, a, b in zip(point, low, high, strict=True)))


def outside_text(metres: float) -> str:
    """In metres, as scans and landmarks of another unit are off by metres; in words where that would be digits."""
    return f"{metres:.2f} m" if metres < 10.0 else distance_text(metres)
