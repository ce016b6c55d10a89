"""Breasts that hang: the family's sources are women of 25 years, none of whom has ptosis.

The tissue in front of the chest wall is sheared downwards: the more, the farther in front of the fold it is, so that
the fold stays where it is and the breast comes to hang over it.  Where it hangs by its own weight alone (`sags`) only
the lower pole sinks: glandular ptosis.  Both maps of space move points along one axis with a slope under one in it, so
that they are one to one and no skin goes through another.
"""

import numpy as np

from breastrig.core.arrays import Array

ACROSS, ALONG = 0.055, 0.085  # m, standard deviations of what sinks with the nipple, sideways and in height
LOWER_POLE, SAG_ALONG = 0.4, 0.045  # share of the way from nipple to fold; m, of what sags there
IN_FRONT = 0.025  # m, least depth of a breast over which the shear grows


def hanging_shift(vertices: Array, places: dict[str, Array], side: str, above_fold: float, sag: float) -> Array:
    """(V, 3) m: one standing breast lowered until its nipple is `above_fold` (m) over its fold; `sag` (m) of its lower
    pole beside that."""
    nipple, fold = places[f"nipple_{side}"], places[f"inframammary_fold_{side}"]
    depth = max(nipple[2] - fold[2], IN_FRONT)
    share = np.clip((vertices[:, 2] - fold[2]) / depth, 0.0, 1.0)
    front = share * share * (3.0 - 2.0 * share)
    pole = nipple + LOWER_POLE * (fold - nipple)

    def sinking(points: Array, middle: Array, along: float) -> Array:
        away = (points - middle)[:, :2] / [ACROSS, along]
        return np.asarray(np.exp(-0.5 * (away**2).sum(axis=1)))

    sagging = sag * sinking(vertices, pole, SAG_ALONG)
    of_nipple = sag * float(sinking(nipple[None], pole, SAG_ALONG)[0])
    hang = float(nipple[1] - fold[1]) - above_fold - of_nipple
    shift = np.zeros_like(vertices)
    shift[:, 1] = -front * (hang * sinking(vertices, nipple, ALONG) + sagging)
    return shift
