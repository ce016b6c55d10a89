"""Proportions of a standing body changed: smooth maps of space, one after the other, each by one drawn number.

Every map moves points by a field with slopes well under one, so that it is one to one.  The landmarks that a map
needs are given as they are at that moment: they are points of the skin and have moved with the maps before.
"""

from collections.abc import Callable

import numpy as np
from scipy.special import ndtr

from breastrig.core.arrays import Array
from breastrig_studies.virtual.warped.numbers import Numbers

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


Places = dict[str, Array]
BLEND = 0.022  # m, standard deviation of the blend between neighbouring segments
HIPS_BELOW = 0.20  # m from the navel down to the widest hips
NAVEL_REACH = 0.065  # m, standard deviation of what goes with the navel
FOLD_REACH = (0.060, 0.036, 0.060)  # m, across, along, in depth
BREAST_REACH = 0.065  # m
NECK = 0.06  # m from the midline, where the shoulders' slope begins
HALF_HIPS = 0.16  # m


def changed(vertices: Array, landmarks: Callable[[Array], Places], numbers: Numbers) -> Array:
    """(V, 3) m: the standing skin with the numbers' proportions; `landmarks` finds the landmarks of a skin."""
    present = landmarks(vertices)
    moved = with_segments(vertices, present, (numbers.notch_xiphoid, numbers.xiphoid_navel, numbers.navel_hips))
    moved = moved + shoulder_shift(moved, landmarks(moved), numbers.shoulders_up)
    moved = moved + hip_shift(moved, landmarks(moved), numbers.hips)
    for side, sign in (("L", 1.0), ("R", -1.0)):
        if side == numbers.mastectomy:
            continue
        index = 0 if side == "L" else 1
        moved = moved + breast_shift(moved, landmarks(moved), side, numbers.sizes[index], numbers.base)
        aside = np.array([sign * numbers.apart, numbers.heights[index], 0.0])
        at = _breast(landmarks(moved), side)
        moved = moved + _bell(moved - at, (BREAST_REACH,) * 3)[:, None] * aside
        fold = landmarks(moved)[f"inframammary_fold_{side}"]
        moved = moved + _bell(moved - fold, FOLD_REACH)[:, None] * np.array([0.0, numbers.folds_up[index], 0.0])
        if numbers.nipples_over_folds is not None:
            above = numbers.nipples_over_folds[index]
            moved = moved + hanging_shift(moved, landmarks(moved), side, above, numbers.sag)
    navel = landmarks(moved)["umbilicus"]
    return np.asarray(
        moved + _bell(moved - navel, (NAVEL_REACH,) * 3)[:, None] * np.array([0.0, numbers.navel_up, 0.0])
    )


def with_segments(vertices: Array, places: Places, longer: tuple[float, float, float]) -> Array:
    """Heights stretched so that notch-xiphoid, xiphoid-navel and navel-hips become longer by exactly these shares.

    The slope of the height is one plus a smoothed step in each segment; how much a segment's step leaks into its
    neighbours is linear, so the three steps are solved for.
    """
    notch, xiphoid, navel = (places[name][1] for name in ("suprasternal_notch", "xiphoid", "umbilicus"))
    ends = [(xiphoid, notch), (navel, xiphoid), (navel - HIPS_BELOW, navel)]

    def growth(height: Array) -> Array:
        """(M, 3): how much each segment's unit step raises these heights, from the navel up and down."""
        raised = np.stack([_ramp(height - low) - _ramp(height - high) for low, high in ends], axis=-1)
        still = np.array([_ramp(navel - low) - _ramp(navel - high) for low, high in ends])
        return np.asarray(raised - still)

    gained = np.array([growth(np.array([high]))[0] - growth(np.array([low]))[0] for low, high in ends])
    steps = np.linalg.solve(
        gained, np.array([share * (high - low) for share, (low, high) in zip(longer, ends, strict=True)])
    )
    moved = vertices.copy()
    moved[:, 1] += growth(vertices[:, 1]) @ steps
    return moved


def shoulder_shift(vertices: Array, places: Places, up: float) -> Array:
    """(V, 3) m: shoulders and arms raised by `up` (m) at the acromion, fading to the neck and down the trunk."""
    shift = np.zeros_like(vertices)
    for side, sign in (("L", 1.0), ("R", -1.0)):
        acromion = places[f"acromion_{side}"]
        out = _rise((sign * vertices[:, 0] - NECK) / (abs(acromion[0]) - NECK))
        low = places["xiphoid"][1]
        shift[:, 1] += up * out * _rise((vertices[:, 1] - low) / (acromion[1] - 0.05 - low))
    return shift


def hip_shift(vertices: Array, places: Places, wider: float) -> Array:
    """(V, 3) m: the pelvis wider and deeper by a share, fading to the navel; arms beside it are only pushed aside."""
    level = places["umbilicus"][1]
    much = wider * _rise((level + 0.02 - vertices[:, 1]) / (0.6 * HIPS_BELOW))
    shift = np.zeros_like(vertices)
    shift[:, 0] = much * HALF_HIPS * np.tanh(vertices[:, 0] / HALF_HIPS)
    shift[:, 2] = much * 0.12 * np.tanh(vertices[:, 2] / 0.12)
    return shift


def breast_shift(vertices: Array, places: Places, side: str, larger: float, wider: float) -> Array:
    """(V, 3) m: one breast larger by a share, seen from the wall behind it, and its base wider by a share."""
    at = _breast(places, side)
    away = vertices - (at - [0.0, 0.0, 0.05])
    much = _bell(vertices - at, (BREAST_REACH,) * 3)
    shift = (larger * much)[:, None] * away
    shift[:, 0] += wider * much * (vertices[:, 0] - at[0])
    return np.asarray(shift)


def _breast(places: Places, side: str) -> Array:
    """(3,) m: the middle of a breast, a little behind and above the line from fold to nipple."""
    nipple, fold = places[f"nipple_{side}"], places[f"inframammary_fold_{side}"]
    return np.asarray(0.7 * nipple + 0.3 * fold + [0.0, 0.02, -0.015])


def _bell(away: Array, reach: tuple[float, float, float]) -> Array:
    """(V,) one in the middle."""
    return np.asarray(np.exp(-0.5 * ((away / np.array(reach)) ** 2).sum(axis=1)))


def _rise(share: Array) -> Array:
    """(V,) 0 below 0, 1 above 1, smooth between."""
    share = np.clip(share, 0.0, 1.0)
    return np.asarray(share * share * (3.0 - 2.0 * share))


def _ramp(height: Array) -> Array:
    """The integral of a step that is smoothed by BLEND: 0 far below, the height far above."""
    share = np.asarray(height) / BLEND
    return np.asarray(BLEND * (share * ndtr(share) + np.exp(-0.5 * share**2) / np.sqrt(2.0 * np.pi)))
