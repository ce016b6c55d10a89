"""Landmarks are checked at the door: known names, and points that can be meant for this scan."""

from collections.abc import Sequence

from breastrig.api.beyond_scan import metres_outside, outside_text
from breastrig.api.served_model import ServedModel
from breastrig.core.errors import BadLandmarks, unknown_name
from breastrig.scan.landmark_files import checked_certain
from breastrig.storage.rows.scans import Points, ScanRow

REACH_M = 0.25  # a landmark may lie in a hole or beside the seen part, but not further out than this


def check_landmarks(points_mm: Points, certain: Sequence[str], scan: ScanRow, model: ServedModel) -> None:
    """Raises BadLandmarks with a sentence."""
    checked_certain(certain, points_mm, {})
    names = model.rig.landmark_names
    for name, point in points_mm.items():
        if name not in names:
            raise BadLandmarks(unknown_name("landmark", name, names))
        outside = metres_outside(point, scan)
        if outside > REACH_M:
            raise BadLandmarks(
                f"{name} lies {outside_text(outside)} outside of the scan; landmarks are millimetres in the scan's own "
                f"frame, and this scan was read in {scan.facts['unit']}."
            )
