"""Coverage of radii at several levels: the counts behind a reliability plot.

The program states one radius, that of 90 %. Other levels follow from it: places scatter over the skin, in two
directions alike, so a radius of level p is the share sqrt(ln(1 - p) / ln(0.1)) of it.
"""

import numpy as np

from breastrig.core.arrays import Array

LEVELS = (0.5, 0.8, 0.9, 0.95)
SHARES = tuple(float(np.sqrt(np.log(1.0 - level) / np.log(0.1))) for level in LEVELS)  # of the radius of 90 %


def covered_at_levels(errors: Array, radii: Array) -> list[int]:
    """The number of the (M,) m errors within each level's radius ((M,) m radii of 90 %), and M."""
    return [*(int((errors <= share * radii).sum()) for share in SHARES), len(errors)]


def add_up(sums: dict[str, list[int]], group: str, counts: list[int]) -> None:
    """Adds counts to those of the group."""
    before = sums.get(group, [0] * len(counts))
    sums[group] = [old + new for old, new in zip(before, counts, strict=True)]
