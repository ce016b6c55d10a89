"""A scan brought to its true size by a straight length that was measured on the patient.

Apps are off by some per cent.  Scan, landmarks and marks are scaled together about the origin of the scan's frame,
before anything else is done: all results are in the true size, in the scan's own axes and unit.

The length of a kept scan has a file of its own beside the scan, which is read in its true size.
"""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from breastrig.core.arrays import Array
from breastrig.core.errors import BadInput, BadLandmarks
from breastrig.core.picks import Length
from breastrig.scan.unscaled import UNKNOWN_SIZE

LEAST, MOST = (
    0.8,
    1.25,
)  # times its size in the file; a scan farther off was read in a wrong unit, or the length typed so
LONGEST = 3000.0  # mm
Scale = Annotated[float, Field(strict=True, ge=LEAST, le=MOST)]
IN_SIZE = "the scan's size in which places on it are, times that of its file; sent without: its present one"
LENGTHS, PLANES = ("size_m", "bounds_m", "other_pieces"), ("background", "table")  # of a scan's facts, metres
KEPT, SCHEMA = "length.json", "breastrig/length@1"
EXPECTED = 'A length is two names and millimetres, as in ("nipple_L", "suprasternal_notch", 187.0).'


@dataclass(frozen=True)
class TrueSize:
    length: Length
    measured_mm: float  # in the file
    factor: float  # from the file's size to the true one
    ends_mm: tuple[tuple[float, ...], tuple[float, ...]]  # (3,) both places in the file's size

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
    if not isinstance(start, str) or not isinstance(end, str):
        raise BadLandmarks(EXPECTED)
    return Length(start, end, checked_mm(said, f" from {start[:100]} to {end[:100]}"))


def checked_mm(said: object, between: str = "") -> float:
    """The millimetres of a length, or of a text. Raises BadLandmarks."""
    try:
        is_one = isinstance(said, str | float | int | np.number) and not isinstance(said, bool)
        mm = float(said) if is_one else math.nan  # type: ignore[arg-type]
    except ValueError:
        mm = math.nan
    if not 0.0 < mm <= LONGEST:
        raise BadLandmarks(f'The length{between} must be a number of millimetres above 0, not "{said}".'[:300])
    return mm


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
    apart = 1e3 * float(np.linalg.norm(places[length.start] - places[length.end]))
    measured = round(apart, 6)  # the same size where a length is given back, to the last bit
    if not measured * LEAST <= length.mm <= measured * MOST:
        raise BadLandmarks(
            f"From {length.start} to {length.end} it is {measured:.0f} mm in the scan, but {length.mm:g} mm were "
            "given; check the scan's unit and the millimetres."
        )
    ends = places[length.start], places[length.end]
    return TrueSize(length, measured, length.mm / measured, (_in_mm(ends[0]), _in_mm(ends[1])))


def _in_mm(place: Array) -> tuple[float, ...]:
    return tuple((1e3 * place).tolist())


def kept_document(size: TrueSize) -> dict[str, Any]:
    """breastrig/length@1: places and the length between them in the size of the scan's file, mm."""
    start, end = size.ends_mm
    known = {"from": size.length.start, "from_mm": start, "to": size.length.end, "to_mm": end}
    return {"schema": SCHEMA} | known | {"measured_mm": size.measured_mm, "length_mm": size.length.mm}


def kept_size(folder: Path) -> TrueSize | None:
    """The true size of the scan that is kept in the folder; None: its file has it.  BadInput for a damaged file."""
    try:
        content = (folder / KEPT).read_bytes()
    except (FileNotFoundError, NotADirectoryError):
        return None
    try:
        found = json.loads(content)
        length = Length(str(found["from"]), str(found["to"]), float(found["length_mm"]))
        start, end = (tuple(map(float, found[name])) for name in ("from_mm", "to_mm"))
        size = TrueSize(length, measured := float(found["measured_mm"]), length.mm / measured, (start, end))
        if LEAST <= size.factor <= MOST and len(start) == len(end) == 3:
            return size
    except (ValueError, KeyError, TypeError, ZeroDivisionError, RecursionError):
        pass
    raise BadInput(f"{KEPT} of this scan is damaged; put a copy back, or remove it.")


def kept_factor(folder: Path) -> float:
    """Of `kept_size`; 1 without one."""
    size = kept_size(folder)
    return 1.0 if size is None else size.factor


def facts_in(facts: dict[str, Any], size: TrueSize) -> dict[str, Any]:
    """A scan's facts, those of its file, in its true size; how its body lies is then searched anew."""
    factor = size.factor
    found = facts | {name: _times(facts[name], factor) for name in LENGTHS if name in facts}
    for name in PLANES:
        found |= {name: _moved(facts[name], factor)} if name in facts else {}
    return found | {
        "cut_away_cm2": round(factor**2 * facts.get("cut_away_cm2", 0)),
        "size_doubt": "",
        "size_known": True,
        "notes": [*(each for each in facts.get("notes", ()) if each != UNKNOWN_SIZE), size.note],
        "orientation": None,
        "scale": scale_facts(size),
    }


def scale_facts(size: TrueSize) -> dict[str, Any]:
    """As `scale` of result.json has it, with both ends in the true size."""
    return {
        "factor": size.factor,
        "between": [size.length.start, size.length.end],
        "mm": size.length.mm,
        "measured_mm": size.measured_mm,
        "ends": [[size.factor * value for value in end] for end in size.ends_mm],
    }


def _moved(plane: Any, factor: float) -> Any:
    """A plane, or a list of them, as far from the origin as it is in the true size."""
    if isinstance(plane, list):
        return [_moved(each, factor) for each in plane]
    return plane if plane is None else plane | {"height_m": factor * plane["height_m"]}


def _times(value: Any, factor: float) -> Any:
    """All numbers of lists and objects times the factor."""
    if isinstance(value, dict):
        return {name: _times(each, factor) for name, each in value.items()}
    if isinstance(value, list):
        return [_times(each, factor) for each in value]
    return value if value is None else factor * value
