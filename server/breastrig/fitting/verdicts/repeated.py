"""Picks that say no more than the scan alone: those that lie where the program itself proposed them.

Who nods at a proposal on a part of a body confirms what it was made of, not where the part belongs: a fit that is held
by nods only is placed by the scan alone, however many there are.  Where the model lies wrong the nods lie wrong with
it, and the fit follows all of them.
"""

from collections.abc import Mapping

import numpy as np

from breastrig.core.arrays import Array

REPEATED = 0.002  # m; at least three true picks of each of 92 parts lie farther from proposals, 3 mm: of all but 3


def picked_names(picks: Mapping[str, Array], proposed: Mapping[str, Array]) -> frozenset[str]:
    """Names of the picks ((3,) m each) that are not where they were proposed."""
    return frozenset(
        name
        for name, place in picks.items()
        if name not in proposed or float(np.linalg.norm(place - proposed[name])) > REPEATED
    )
