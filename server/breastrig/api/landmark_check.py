"""Landmarks are checked at the door: known names, and points that can be meant for this scan."""

import numpy as np

from breastrig.api.beyond_scan import metres_outside, outside_text
from breastrig.api.served_model import ServedModel
from breastrig.core.errors import BadLandmarks, unknown_name
from breastrig.core.units import METRES_PER_UNIT
from breastrig.scan.landmarks.landmark_files import (
    REACH,
    certain_landmarks,
    checked_certain,
    landmark_confidences,
    metres_per_unit,
    read_landmarks,
)
from breastrig.scan.landmarks.names import by_known_names, known_name
from breastrig.storage.rows.scans import Picks, ScanRow


def landmarks_of_file(data: bytes, scan: ScanRow, model: ServedModel) -> Picks:
    """What a file says of landmarks on this scan, in mm and under the model's names.  Raises BadLandmarks."""
    places, unit = read_landmarks(data)
    bounds = scan.facts["bounds_m"]
    metres = metres_per_unit(
        places, unit, METRES_PER_UNIT[scan.facts["unit"]], (np.array(bounds["min"]), np.array(bounds["max"]))
    )
    known = {each.name: (each.label, each.latin) for each in model.rig.landmarks}
    points = {name: (1e3 * metres * place).tolist() for name, place in by_known_names(places, known).items()}
    certain = tuple(known_name(name, known) for name in certain_landmarks(data))
    picks = Picks(points, certain, by_known_names(landmark_confidences(data), known))
    check_landmarks(picks, scan, model)
    return picks


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
        if outside > REACH:
            raise BadLandmarks(
                f"{name} lies {outside_text(outside)} outside of the scan; landmarks are millimetres in the scan's own "
                f"frame, and this scan was read in {scan.facts['unit']}."
            )
