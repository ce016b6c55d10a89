"""Landmarks are checked at the door: known names, and points that can be meant for this scan."""

from breastrig.api.beyond_scan import metres_outside, outside_text
from breastrig.api.served_model import ServedModel
from breastrig.core.errors import BadLandmarks, unknown_name
from breastrig.scan.landmark_files import checked_certain
from breastrig.storage.rows.scans import Picks, ScanRow

REACH_M = 0.25  # a landmark may lie in a hole or beside the seen part, but not further out than this


def check_landmarks(picks: Picks, scan: ScanRow, model: ServedModel) -> None:
    """Raises BadLandmarks with a sentence."""
    checked_certain(picks.certain, picks.points_mm, picks.confidence)
    for name in picks.confidence:
        if name not in picks.points_mm:
            raise BadLandmarks(f'"confidence" names {name}, which is not among these landmarks; take it out.')
    names = model.rig.landmark_names
    for name, point in picks.points_mm.items():
        if name not in names:
            raise BadLandmarks(unknown_name("landmark", name, names))
        outside = metres_outside(point, scan)
        if outside > REACH_M:
            raise BadLandmarks(
                f"{name} lies {outside_text(outside)} outside of the scan; landmarks are millimetres in the scan's own "
                f"frame, and this scan was read in {scan.facts['unit']}."
            )
