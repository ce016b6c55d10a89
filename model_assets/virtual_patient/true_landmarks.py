"""Where the twelve landmarks truly are on the standing patient, as points of the skin that move with it.

Found from the shape alone, each by the rule that a person would follow with a finger; no bone can be felt here,
so xiphoid and acromion are defined by what lies near them.
"""

import numpy as np

from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.rays import RayCaster
from breastrig.geometry.surface_points import SurfacePoints

Array = np.ndarray

STEP = 0.002  # m between the points of a profile
NOTCH_HEIGHT = 0.035  # m above and below the shoulders where the notch may be
NAVEL_HEIGHTS = (0.10, 0.20)  # m
FOLD_REACH = 0.024  # m to both sides of the nipple where the fold is looked for
FOLD_DEPTH = 0.10  # m below the nipple where it must be
STRONG = 0.6  # a fold counts when it turns by this share of the strongest
TO_THE_SKIN = np.array([0.0, -0.5, -0.87])  # the direction in which the mid-clavicular point is pressed on the skin


def true_landmarks(
    vertices: Array,
    faces: Array,
    middle: Array,
    nipples: dict[str, Array],
    shoulders: dict[str, Array],
    fold_reach: float = FOLD_REACH,
) -> dict[str, SurfacePoints]:
    """Each landmark as one surface point.

    vertices (V, 3) m standing, `middle` (V,) the body's own left-right coordinate (0 on the midline), `nipples`
    the tips and `shoulders` the centres of the joints (m).
    """
    search, rays = ClosestPointSearch(vertices, faces), RayCaster(vertices, faces)
    front = max((_evenly(line) for line in _sections(vertices, faces, middle)), key=len)
    front = front[front[:, 2] > np.median(vertices[:, 2])]  # the front half of the section
    heights = front[:, 1]
    bend = _bend(front)
    result = {f"acromion_{side}": _above(rays, side, joint) for side, joint in shoulders.items()}
    shoulder_height = 0.5 * (result["acromion_L"][1] + result["acromion_R"][1])
    notch = front[_best(bend, np.abs(heights - shoulder_height) < NOTCH_HEIGHT)]
    belly = (heights > NAVEL_HEIGHTS[0]) & (heights < NAVEL_HEIGHTS[1])
    navel = front[_best(_smooth(front, 15)[:, 2] - front[:, 2], belly)]
    result |= {"suprasternal_notch": notch, "umbilicus": navel}
    for side, tip in nipples.items():
        result[f"nipple_{side}"] = tip
        result[f"inframammary_fold_{side}"] = _fold(vertices, faces, tip, fold_reach)
        between = 0.5 * (notch + result[f"acromion_{side}"]) + [0.0, 0.005, 0.0]
        direction = TO_THE_SKIN / np.linalg.norm(TO_THE_SKIN)
        result[f"midclavicle_{side}"] = _shot(rays, between - 0.15 * direction, direction)
    fold_height = 0.5 * (result["inframammary_fold_L"][1] + result["inframammary_fold_R"][1])
    low = int(np.abs(heights - fold_height).argmin())
    high = int(np.linalg.norm(front - notch, axis=1).argmin())
    result["xiphoid"] = front[low]
    result["mid_sternum"] = front[(low + high) // 2]  # the profile's points are evenly spaced
    found = {name: search.query(place[None]) for name, place in result.items()}
    return {name: SurfacePoints(point.faces, point.barycentric) for name, point in found.items()}


def _shot(rays: RayCaster, origin: Array, direction: Array) -> Array:
    face, distance = rays.first_hits(origin[None], direction[None], 1.0)
    assert face[0] >= 0, "the ray towards a landmark misses the body"
    return origin + distance[0] * direction


def _above(rays: RayCaster, side: str, joint: Array) -> Array:
    """The skin straight above the shoulder joint, 6 mm to the side."""
    outwards = 0.006 if side == "L" else -0.006
    return _shot(rays, joint + np.array([outwards, 0.3, 0.0]), np.array([0.0, -1.0, 0.0]))


def _fold(vertices: Array, faces: Array, tip: Array, reach: float) -> Array:
    """The lowest of the strong concave places under the breast, on sagittal cuts near the nipple."""
    candidates = []
    for offset in np.arange(-reach, reach + 1e-9, 0.004):
        for line in _sections(vertices, faces, vertices[:, 0] - tip[0] - offset):
            profile = _evenly(line)
            below = (profile[:, 1] < tip[1] - 0.01) & (profile[:, 1] > tip[1] - FOLD_DEPTH)
            below &= profile[:, 2] > tip[2] - 0.10
            if below.any():
                bend = _bend(profile)
                best = _best(bend, below)
                candidates.append((bend[best], profile[best]))
    strongest = max(bend for bend, _ in candidates)
    return min((place for bend, place in candidates if bend > STRONG * strongest), key=lambda place: place[1])


def _best(values: Array, allowed: Array) -> int:
    return int(np.where(allowed, values, -np.inf).argmax())


def _bend(profile: Array) -> Array:
    """(M,) 1/m: curvature of a profile that runs upwards in front, positive where it is hollow."""
    smooth = _smooth(profile, 3)
    first = np.gradient(smooth, STEP, axis=0)
    second = np.gradient(first, STEP, axis=0)
    return first[:, 1] * second[:, 2] - first[:, 2] * second[:, 1]


def _smooth(profile: Array, width: int) -> Array:
    """A moving mean with a Gaussian of `width` points; ends are prolonged."""
    reach = 3 * width
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / width) ** 2)
    padded = np.pad(profile, ((reach, reach), (0, 0)), mode="reflect", reflect_type="odd")
    return np.stack([np.convolve(column, weights / weights.sum(), mode="valid") for column in padded.T], axis=1)


def _evenly(line: Array) -> Array:
    """The polyline with a point every STEP."""
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    at = np.arange(0.0, length[-1], STEP)
    return np.stack([np.interp(at, length, column) for column in line.T], axis=1)


def _sections(vertices: Array, faces: Array, field: Array) -> list[Array]:
    """The closed polylines (M, 3) where a (V,) field is zero, from the back over the lower end up the front.

    The surface must be closed.
    """
    value = np.where(np.abs(field) < 1e-9, 1e-9, field)  # no vertex lies exactly on the cut
    side = value[faces] > 0
    cut = faces[side.any(axis=1) & ~side.all(axis=1)]
    segments = []
    for face in cut.tolist():
        ends = [
            (min(a, b), max(a, b)) for a, b in zip(face, face[1:] + face[:1], strict=True) if value[a] * value[b] < 0
        ]
        segments.append(ends)
    meeting: dict[tuple[int, int], list[int]] = {}
    for index, ends in enumerate(segments):
        for end in ends:
            meeting.setdefault(end, []).append(index)
    lines, used = [], [False] * len(segments)
    for start in meeting:
        chain = [start]
        while True:
            step = next((k for k in meeting[chain[-1]] if not used[k]), None)
            if step is None:
                break
            used[step] = True
            a, b = segments[step]
            chain.append(b if a == chain[-1] else a)
        if len(chain) > 3:
            lines.append(_up_the_front(_crossings(vertices, value, np.array(chain[:-1]))))
    return lines


def _crossings(vertices: Array, value: Array, edges: Array) -> Array:
    """(M, 3): where the value is zero on each of (M, 2) edges."""
    a, b = value[edges[:, 0]], value[edges[:, 1]]
    share = (a / (a - b))[:, None]
    return (1.0 - share) * vertices[edges[:, 0]] + share * vertices[edges[:, 1]]


def _up_the_front(loop: Array) -> Array:
    """The (M, 3) closed loop so turned that it starts at the back and goes up in front."""
    y, z = loop[:, 1], loop[:, 2]
    if np.sum(y * np.roll(z, -1) - np.roll(y, -1) * z) > 0:
        loop = loop[::-1]
    return np.roll(loop, -int(loop[:, 2].argmin()), axis=0)
