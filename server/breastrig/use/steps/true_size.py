"""A scan brought to its true size by a straight length that was measured on the patient.

Apps are off by some per cent.  Scan, landmarks and marks are scaled together about the origin of the scan's frame,
before anything else is done: all results are in the true size, in the scan's own axes and unit.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadLandmarks
from breastrig.core.picks import Length
from breastrig.scan.scan import Scan

LEAST, MOST = (
    0.8,
    1.25,
)  # times its size in the file; a scan farther off was read in a wrong unit, or the length typed so
LONGEST = 3000.0  # mm
EXPECTED = 'A length is two names and millimetres, as in ("nipple_L", "suprasternal_notch", 187.0).'


@dataclass(frozen=True)
class TrueSize:
    length: Length
    measured_mm: float  # in the file
    factor: float  # from the file's size to the true one

    @property
    def note(self) -> str:
        """A sentence for people."""
        between, mm = f"{self.length.start} to {self.length.end}", f"{self.length.mm:g} mm"
        return (
            f"Scaled by {self.factor:.3f}: {mm} from {between}, {self.measured_mm:.1f} mm in the file. "
            "All results are in this size."
        )


def length_of(given: Sequence[object] | None) -> Length | None:
    """The length of two names and millimetres, or of their texts. Raises BadLandmarks."""
    if given is None:
        return None
    if isinstance(given, str) or len(given) != 3:
        raise BadLandmarks(EXPECTED)
    start, end, said = given
    if not isinstance(start, str) or not isinstance(end, str) or isinstance(said, bool):
        raise BadLandmarks(EXPECTED)
    try:
        mm = float(said) if isinstance(said, str | float | int | np.number) else math.nan
    except ValueError:
        mm = math.nan
    if not 0.0 < mm <= LONGEST:
        raise BadLandmarks(
            f'The length from {start[:100]} to {end[:100]} must be a number of millimetres above 0, not "{said}".'[:300]
        )
    return Length(start, end, mm)


def true_size(length: Length, places: Mapping[str, Array]) -> TrueSize:
    """How a scan with these (3,) m places gets its true size; the length has the places' names.

    Raises BadLandmarks for a length between other places, and for one that makes another size than a scan's errors do.
    """
    if length.start == length.end:
        raise BadLandmarks(f"A length has two ends, and both are {length.start}; name another landmark or mark.")
    for name in (length.start, length.end):
        if name not in places:
            known = ", ".join(places) or "none"
            raise BadLandmarks(
                f'The length ends at "{name[:100]}", no landmark or mark of this scan; there are: {known}.'
            )
    measured = 1e3 * float(np.linalg.norm(places[length.start] - places[length.end]))
    if not measured * LEAST <= length.mm <= measured * MOST:
        raise BadLandmarks(
            f"From {length.start} to {length.end} it is {measured:.0f} mm in the scan, but {length.mm:g} were given; "
            "are the scan's unit and the millimetres right?"
        )
    return TrueSize(length, measured, length.mm / measured)


def in_true_size(scan: Scan, size: TrueSize) -> Scan:
    """The scan in its true size. Raises BadLandmarks for an image, whose file knows its own."""
    if scan.in_patient_frame:
        raise BadLandmarks("An image has its true size already; leave the length out.")
    return replace(scan, vertices=size.factor * scan.vertices, notes=(*scan.notes, size.note))
