"""A landmark as the form expects it and as colours show it; imports no image filters."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from breastrig.core.arrays import Array

if TYPE_CHECKING:
    from breastrig.colour.features.areola import Areola

NIPPLES = {"L": "nipple_L", "R": "nipple_R"}
NAVEL = "umbilicus"
CROSSED = ("suprasternal_notch", "xiphoid")
BETWEEN_CROSSES = "mid_sternum"
LOOKED_FOR = frozenset({*NIPPLES.values(), NAVEL, *CROSSED, BETWEEN_CROSSES})  # no other landmark shows in colours


@dataclass(frozen=True, eq=False)
class Expectation:
    """A landmark's location according to the form."""

    place: Array  # (3,) m, in the scan's frame
    outwards: Array  # (3,) unit, out of the body there
    spread: float  # m, root mean square error


@dataclass(frozen=True, eq=False)
class Observation:
    """A landmark that colour shows; the model, whose shapes need not reach it, may end beside."""

    place: Array  # (3,) m, on the skin, in the scan's frame
    covariance: Array  # (3, 3) m²
    reason: str  # what shows it, a few words
    areola: "Areola | None" = None  # of a nipple, with which it was found

    @property
    def error(self) -> float:
        """m, root mean square."""
        return float(np.sqrt(np.trace(self.covariance)))
