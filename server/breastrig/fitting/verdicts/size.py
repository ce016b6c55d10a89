"""Whether a fitted body has the size of an adult woman: scans of photogrammetry have none of their own.

Lengths on the trunk say how much larger she is than most, by generalised least squares over their logarithms, whose
covariance is that of women plus the fit's errors.  Kept beside the rig; docs/decisions/0022.
"""

from typing import Literal

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.settings_file import Positive, SettingsPart
from breastrig.core.stances import STANCES
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.body.hanging import body_axes
from breastrig.rig.model import Rig

SHOWN = 0.015  # m from the scan to a landmark that is seen
AXES = {"left": 0, "up": 1}


class Length(SettingsPart):
    """Between two landmarks along an axis of the body."""

    ends: tuple[str, str]
    along: Literal["left", "up"]
    mean: Positive  # m, of women
    spread: Positive  # standard deviation of its logarithm
    error: Positive  # likewise, what fit and definitions add
    stances: tuple[str, ...] = STANCES  # in which it is as long


class SizeLimits(SettingsPart):
    asked: Positive  # standard deviations from the mean size, from which on it is asked about
    unlikely: Positive  # likewise, from which on the fit is to be checked before anything is measured in it
    correlation: float  # of the lengths among women
    lengths: tuple[Length, ...]


def times_larger(
    rig: Rig, vertices: Array, target: ScanTarget, stance: str, limits: SizeLimits
) -> tuple[float, float] | None:
    """((V, 3) m fitted vertices' size in that of most women, deviations from it); None where none is seen or named."""
    if not {end for length in limits.lengths for end in length.ends} <= {*rig.landmark_names}:
        return None
    axes, seen, gaps = body_axes(rig, vertices), [], []
    for length in (each for each in limits.lengths if stance in each.stances):
        ends = rig.landmark_points(length.ends).positions(vertices, rig.faces)
        apart = abs(float((ends[0] - ends[1]) @ axes[:, AXES[length.along]]))
        if np.isfinite(target.vertex_tree.query(ends, distance_upper_bound=SHOWN)[0]).all() and apart > 0.0:
            seen.append(length)
            gaps.append(np.log(apart / length.mean))
    if not seen:
        return None
    spreads = np.array([length.spread for length in seen])
    among = np.where(np.eye(len(seen)) > 0.0, 1.0, limits.correlation) * np.outer(spreads, spreads)
    precision = np.linalg.inv(among + np.diag([length.error**2 for length in seen]))
    size = float(precision.sum(axis=0) @ np.array(gaps) / precision.sum())
    return float(np.exp(size)), size * float(np.sqrt(precision.sum()))
