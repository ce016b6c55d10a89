"""What every reader promises: sound data, or one sentence."""

import numpy as np

from breastrig.core.errors import BadInput
from breastrig.scan.landmarks.landmark_files import read_landmarks
from breastrig.scan.read import read_scan
from helpers.fuzz_table import count


def is_sentence(error: BadInput) -> bool:
    return str(error).endswith(".") and "\n" not in str(error)


def refused_or_sound(data: bytes, named: str | None = None, units: str = "m") -> None:
    """Reads a scan; a label map has a unit of its own, `auto`."""
    refused = None
    try:
        scan = read_scan(data, named, units)
    except BadInput as error:
        refused = error
    count(f"scan {named or 'of any kind'}", "read" if refused is None else "refused")
    if refused is not None:
        assert is_sentence(refused)
        return
    assert np.isfinite(scan.vertices).all()
    assert scan.faces.min() >= 0
    assert scan.faces.max() < len(scan.vertices)
    assert scan.colours is None or scan.colours.shape == scan.vertices.shape
    assert (scan.uv is None) == (scan.texture is None)


def sound_landmarks_or_refused(data: bytes) -> None:
    """Reads a landmark file."""
    refused = None
    try:
        places, _ = read_landmarks(data)
    except BadInput as error:
        refused = error
    count("landmarks", "read" if refused is None else "refused")
    if refused is not None:
        assert is_sentence(refused)
        return
    assert places
    assert all(place.shape == (3,) and np.isfinite(place).all() for place in places.values())
