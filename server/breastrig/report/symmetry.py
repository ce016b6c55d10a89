"""The ratios M1 to M6 of breast symmetry (Reddy et al. 2017, PMC5685181, figure 1), from 0 to 1 = symmetric.

There they are read off a photograph from the front; here off the body's own left and up, so that neither a turned
patient nor a turned camera counts as asymmetry.  M1 compares the nipples' difference in height with their distance
across; the others are the smaller over the larger of left and right.  With N the nipples, V the lowest and L the
most lateral point of each breast (of the model inside its breast outline), S the notch:

    M1 = 1 − |N_L − N_R|_up / |N_L − N_R|_across   M2: N to V, up      M3: N to midline, across
    M4: N to L, across                             M5: V to S, up      M6: L to midline, across
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import SIDES
from breastrig.report.bands import (
    OF_LENGTH,
    OF_RATIO,
    Joint,
    Points,
    banded,
    outwards,
    ratio_half_width,
    shared_half_width,
    ways_to_midline,
)
from breastrig.report.body_frame import BodyFrame
from breastrig.report.calibration import Spread, measure_calibration
from breastrig.report.stance import Place, Stance
from breastrig.report.table import Row
from breastrig.report.volume import vertices_within

MODEL_PART = "model inside its breast base outline"


def symmetry(stance: Stance, frame: BodyFrame, known: Mapping[str, Place], joint: Joint | None = None) -> Iterator[Row]:
    """The rows of a rig with nipples; M2, M4, M5, M6 only with outlines of the breasts.

    `joint`: covariance of the landmarks for differences of both sides; none: independent errors.
    """
    nipples = [known["nipple_L"], known["nipple_R"]]
    across = np.abs([float(frame.lateral(place.point)) for place in nipples])
    heights = np.array([float(frame.height(place.point)) for place in nipples])
    apart = float(abs(frame.lateral(nipples[0].point) - frame.lateral(nipples[1].point)))
    names = tuple(map(str, nipples))
    how = "of left and right, the smaller over the larger: "
    level = max(0.0, 1.0 - abs(heights[0] - heights[1]) / max(apart, 1e-9))
    up = frame.axes[:, 1]
    off = shared_half_width([(nipples[0], up), (nipples[1], -up)], joint, OF_RATIO)
    half = None if off is None else off / max(apart, 1e-9)
    points = np.array([place.point for place in nipples])
    how_level = "1 less their difference in height over their distance across"
    yield _row("M1", "nipple heights", level, half, names, how_level, {"value": points})
    to_midline = _sides(points, frame.on_plane(points))
    ways = [  # without what the landmarks share the plane has no error of its own
        [(place, outwards(place, frame))] if joint is None else ways_to_midline(place, frame, known)
        for place in nipples
    ]
    found = _ratio(across, ways, Points(), joint)
    yield _row("M3", "nipple to midline", *found, names, how + "nipple to median plane, across", to_midline)
    members = [vertices_within(stance.rig, side) for side in SIDES]
    if any(part is None for part in members):
        return
    places = [stance.vertices[part] for part in members]
    low = [skin[frame.height(skin).argmin()] for skin in places]
    far = [skin[np.abs(frame.lateral(skin)).argmax()] for skin in places]
    lowest, lateral = frame.height(np.array(low)), np.abs(frame.lateral(np.array(far)))
    to_lowest, to_lateral = (_sides(points, np.array(ends)) for ends in (low, far))
    at_lowest, at_lateral = _ends(stance, low, far)
    outline = (MODEL_PART,)
    upwards, inwards = (
        [[(place, way)] for place, way in zip(nipples, each, strict=True)]
        for each in ((up, up), [-outwards(place, frame) for place in nipples])
    )
    heights_ratio = _ratio(heights - lowest, upwards, at_lowest, joint, OF_LENGTH)
    across_ratio = _ratio(lateral - across, inwards, at_lateral, joint, OF_LENGTH)
    yield _row("M2", "nipple to lowest point", *heights_ratio, names + outline, how + "in height", to_lowest)
    yield _row("M4", "nipple to lateral end", *across_ratio, names + outline, how + "across", to_lateral)
    if "suprasternal_notch" in known:
        notch = known["suprasternal_notch"]
        drop = float(frame.height(notch.point)) - lowest
        to_notch = _sides(np.array(low), np.array([notch.point, notch.point]))
        found = _ratio(drop, [[(notch, up)]] * 2, at_lowest, joint)
        yield _row("M5", "lowest point to notch", *found, (str(notch), *outline), how + "in height", to_notch)
    ends = np.array(far)
    to_middle = _sides(ends, frame.on_plane(ends))
    found = _ratio(lateral, [[], []], at_lateral, joint)
    yield _row("M6", "lateral end to midline", *found, outline, how + "across", to_middle)


def _ratio(
    pair: Array,
    ends: Sequence[Sequence[tuple[Place, Array]]],
    points: Points,
    joint: Joint | None,
    part: float = OF_RATIO,
) -> tuple[float, float | None]:
    """The smaller over the larger, and half the width of its band."""
    low, high = np.sort(np.abs(pair))
    return float(low / high) if high > 0.0 else 1.0, ratio_half_width(pair.tolist(), ends, points, joint, part)


def _ends(stance: Stance, low: Sequence[Array], far: Sequence[Array]) -> tuple[Points, Points]:
    """Errors of the (3,) m lowest points of both breasts in height, and of the most lateral ones across.

    For a rig that nobody has measured they are a share of the points' radii, and independent.
    """
    known = measure_calibration(stance.rig)
    found = []
    for ends, name in ((low, "lowest"), (far, "lateral")):
        error, shared = (
            (Spread(least=0.0, share=OF_RATIO), 0.0)
            if known is None
            else (getattr(known.ends, name), getattr(known.sides, name))
        )
        radii = [stance.radius_at(point[None]) for point in ends]
        left, right = (None if radius is None else error.of(radius) for radius in radii)
        found.append(Points((left, right), shared))
    return found[0], found[1]


def _sides(a: Array, b: Array) -> dict[str, Array]:
    """The lines from (2, 3) m left and right to (2, 3) m."""
    return {"left": np.stack([a[0], b[0]]), "right": np.stack([a[1], b[1]])}


def _row(
    name: str,
    label: str,
    ratio: float,
    half: float | None,
    landmarks: tuple[str, ...],
    method: str,
    paths: Mapping[str, Array],
) -> Row:
    value = banded(ratio, half, 0.0, 1.0)
    return Row(name, f"{name}  {label}", "ratio", "1", None, None, value, landmarks, method, paths)
