"""The areolae found in a scan's colours when it was fitted, as result.json keeps them for the measures.

A side that was searched without success (covered, reconstructed without pigment, no skin there) is null; scans without
a texture have no such entry.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.files.result import ResultAreola, ResultFile

RIM_DIGITS = 6  # of m, as landmarks have


@dataclass(frozen=True, eq=False)
class ObservedAreola:
    """One areola, in the scan's frame."""

    diameter: float  # m, of the circle of its area, along the skin
    half: float  # m, half the band that holds the true one with 90 %
    rim: Array  # (P, 3) m, its border, closed


def areolae_document(
    found: Mapping[str, ObservedAreola | None], metres_per_unit: float
) -> dict[str, ResultAreola | None]:
    """The areolae by side as in result.json, borders in the scan's unit."""
    return {
        side: None
        if each is None
        else ResultAreola(
            diameter_mm=round(1e3 * each.diameter, 2),
            within_mm=round(1e3 * each.half, 2),
            rim=np.round(each.rim / metres_per_unit, RIM_DIGITS).tolist(),
        )
        for side, each in found.items()
    }


def areolae_of(result: ResultFile, metres_per_unit: float) -> dict[str, ObservedAreola | None]:
    """The areolae of a result.json; empty where it has no such entry."""
    return {
        side: None
        if each is None
        else ObservedAreola(1e-3 * each.diameter_mm, 1e-3 * each.within_mm, metres_per_unit * np.array(each.rim))
        for side, each in result.areolae.items()
    }
