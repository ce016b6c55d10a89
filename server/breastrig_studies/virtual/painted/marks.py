"""Marks on a virtual patient's skin: areolae, ink, moles, scars, veins, all as points of the true standing skin.

Points follow the skin, so the same marks lie right on the lying body. Lines are laid out as seen from the front and
projected on the skin along that direction.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import face_crosses, unit_vectors
from breastrig.geometry.polyline import resampled
from breastrig.geometry.rays import RayCaster
from breastrig.geometry.surface_points import SurfacePoints
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.painted.tones import INKS

SPACING = 0.0008  # m between the points of a line
RIM_POINTS = 120
OFF_CENTRE = 0.002  # m on each axis, standard deviation of the areola's middle from the nipple
FRONT = 0.5  # m before the body, from where lines are dropped
NATURAL, COVERED, RECONSTRUCTED = "natural", "covered", "reconstructed"
STATES = (NATURAL, COVERED, RECONSTRUCTED)
PLANS = ("none", "lumpectomy", "reduction", "mastectomy")


@dataclass(frozen=True, eq=False)
class Areola:
    """Around a point beside the nipple: r(θ) = radius (1 + e cos 2(θ - turn) + f cos 3(θ - g)) in the skin's plane
    there; real nipples are seldom in the middle of their areola."""

    side: str  # L | R
    state: str  # natural | covered | reconstructed
    nipple: Array  # (3,) m on the standing skin
    centre: Array  # (3,) m, likewise
    axes: Array  # (3, 3) rows: two in the plane, the normal
    radius: float  # m, mean
    shape: tuple[float, float, float, float]  # e, turn, f, g
    softness: float  # m, of the colour's border
    nipple_radius: float  # m
    rim: SurfacePoints  # where the border is, at the middle of its softness

    def reach(self, angle: Array) -> Array:
        """m, where the border lies in these directions."""
        e, turn, f, g = self.shape
        return np.asarray(self.radius * (1.0 + e * np.cos(2 * (angle - turn)) + f * np.cos(3 * (angle - g))))


@dataclass(frozen=True, eq=False)
class Stroke:
    """A line on the skin."""

    name: str
    closed: bool
    color: str  # #rrggbb of the marker
    lab: Array  # (3,)
    width: float  # m
    strength: float  # 0 to 1, how much of the skin it hides
    points: SurfacePoints
    inked: Booleans  # per point; False in gaps of the pen


@dataclass(frozen=True, eq=False)
class Spot:
    """A mole."""

    place: Array  # (3,) m on the standing skin
    radius: float  # m


@dataclass(frozen=True, eq=False)
class Marks:
    """All marks of one patient."""

    areolae: tuple[Areola, ...]
    ink: tuple[Stroke, ...]
    scars: tuple[Stroke, ...]
    veins: tuple[Stroke, ...]
    spots: tuple[Spot, ...]


class Skin:
    """The standing skin, ready for marks."""

    def __init__(self, body: VirtualBody, faces: Integers) -> None:
        self.body, self.vertices, self.faces = body, body.vertices, faces
        self.search = ClosestPointSearch(body.vertices, faces)
        self.normals = unit_vectors(face_crosses(body.vertices, faces))  # (F, 3)
        self._rays = RayCaster(body.vertices, faces)

    def nearest(self, points: Array) -> SurfacePoints:
        """(M, 3) m -> the skin's points nearest to them."""
        found = self.search.query(points)
        return SurfacePoints(found.faces, found.barycentric)

    def places(self, points: SurfacePoints) -> Array:
        """(M, 3) m"""
        return points.positions(self.vertices, self.faces)

    def dropped(self, flat: Array) -> Array:
        """(M, 3) m: (M, 2) x, y as seen from the front, on the foremost skin there; those that miss are left out."""
        origins = np.column_stack([flat, np.full(len(flat), FRONT)])
        _, distance = self._rays.first_hits(origins, np.tile([0.0, 0.0, -1.0], (len(flat), 1)))
        hit = np.isfinite(distance)
        return np.column_stack([flat[hit], FRONT - distance[hit]])

    def line(self, flat: Array, closed: bool = False) -> Array:
        """(P, 3) m along the skin, SPACING apart, from corners (M, 2) seen from the front."""
        return resampled(self.dropped(resampled_flat(flat, 0.001, closed)), SPACING, closed)


def resampled_flat(flat: Array, spacing: float, closed: bool) -> Array:
    """(N, 2) evenly along (M, 2)."""
    return resampled(np.column_stack([flat, np.zeros(len(flat))]), spacing, closed)[:, :2]


def draw_marks(
    body: VirtualBody,
    faces: Integers,
    random: np.random.Generator,
    plan: str,
    states: dict[str, str],
    inks: tuple[str, str] | None = None,
) -> Marks:
    """Marks for a standing body; `plan` is one of PLANS, `states` says which nipples are not natural (by L, R).

    `inks` as in `draw_plan`.
    """
    skin = Skin(body, faces)
    size, softness = random.uniform(0.014, 0.027), random.uniform(0.0006, 0.0025)
    areolae = tuple(
        _areola(skin, side, states.get(side, NATURAL), size * random.uniform(0.92, 1.09), softness, random)
        for side in ("L", "R")
        if f"nipple_{side}" in body.landmarks
    )
    front = body.vertices[(body.vertices[:, 2] > 0.0) & (np.abs(body.vertices[:, 0]) < 0.2)]
    spots = tuple(
        Spot(
            front[int(random.integers(len(front)))] + random.normal(0.0, 0.004, 3),
            float(random.uniform(0.0008, 0.0032)),
        )
        for _ in range(int(random.integers(4, 22)))
    )
    scars = tuple(
        _wandering(skin, f"scar_{k + 1}", front, random, 0.02, 0.09, 0.0018, np.array([6.0, 3.0, -3.0]), 0.7)
        for k in range(int(random.integers(0, 4)))
    )
    veins = tuple(
        _wandering(skin, f"vein_{k + 1}", front, random, 0.06, 0.16, 0.0030, np.array([-3.0, -2.0, -5.0]), 0.6)
        for k in range(int(random.integers(2, 7)))
    )
    return Marks(areolae, draw_plan(skin, plan, random, inks), scars, veins, spots)


def _areola(skin: Skin, side: str, state: str, radius: float, softness: float, random: np.random.Generator) -> Areola:
    nipple = skin.body.landmarks[f"nipple_{side}"]
    near = np.linalg.norm(skin.vertices - nipple, axis=1) < 0.02
    corners = skin.vertices[skin.faces[near[skin.faces].all(axis=1)]]
    normal = _unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).sum(axis=0))
    across = _unit(np.cross([0.0, 1.0, 0.0], normal))
    axes = np.stack([across, np.cross(normal, across), normal])
    centre = skin.places(skin.nearest((nipple + random.normal(0.0, OFF_CENTRE, 2) @ axes[:2])[None]))[0]
    shape = (random.uniform(0.0, 0.10), random.uniform(0, np.pi), random.uniform(0.0, 0.03), random.uniform(0, np.pi))
    tip = float(random.uniform(0.0045, 0.0065))
    unplaced = skin.nearest(centre[None])
    plain = Areola(side, state, nipple, centre, axes, radius, shape, softness, tip, unplaced)
    angle = np.linspace(0.0, 2.0 * np.pi, RIM_POINTS, endpoint=False)
    reach = plain.reach(angle)[:, None]
    points = centre + reach * (np.cos(angle)[:, None] * axes[0] + np.sin(angle)[:, None] * axes[1])
    for _ in range(8):  # onto the skin, then back to the border's distance
        points = skin.places(skin.nearest(points)) - centre
        points = centre + reach * points / np.linalg.norm(points, axis=1, keepdims=True)
    return replace(plain, rim=skin.nearest(points))


def _stroke(
    skin: Skin, name: str, line: Array, closed: bool, pen: tuple[str, float, float], inked: Booleans | None = None
) -> Stroke:
    ink, width, strength = pen
    color, lab = INKS[ink]
    drawn = np.ones(len(line), dtype=np.bool_) if inked is None else inked
    return Stroke(name, closed, color, np.array(lab), width, strength, skin.nearest(line), drawn)


def _wandering(
    skin: Skin,
    name: str,
    front: Array,
    random: np.random.Generator,
    shortest: float,
    longest: float,
    width: float,
    lab: Array,
    strength: float,
) -> Stroke:
    """A curved line somewhere on the front; `lab` is its shift from the skin."""
    start = front[int(random.integers(len(front))), :2]
    steps = max(int(random.uniform(shortest, longest) / 0.004), 3)
    angle = random.uniform(0.0, 2.0 * np.pi) + np.cumsum(random.normal(0.0, 0.12, steps))
    flat = start + np.cumsum(0.004 * np.column_stack([np.cos(angle), np.sin(angle)]), axis=0)
    line = skin.line(flat)
    if len(line) < 2:
        line = skin.places(skin.nearest(np.column_stack([flat, np.full(len(flat), 0.1)])))
    return Stroke(name, False, "#808080", lab, width, strength, skin.nearest(line), np.ones(len(line), dtype=np.bool_))


def draw_plan(
    skin: Skin, plan: str, random: np.random.Generator, inks: tuple[str, str] | None = None
) -> tuple[Stroke, ...]:
    """A surgeon's lines, of one of the PLANS, in two `inks`, of most lines and of the rest; drawn when not given."""
    if plan == "none":
        return ()
    drawn = (str(ink) for ink in random.choice(list(INKS), 2, replace=False))
    main, second = drawn if inks is None else inks
    pen = (main, float(random.uniform(0.0010, 0.0022)), float(random.uniform(0.6, 0.92)))
    other = (second, float(random.uniform(0.0010, 0.0022)), float(random.uniform(0.6, 0.92)))
    at = {name: place[:2] for name, place in skin.body.landmarks.items()}
    strokes: list[Stroke] = []

    def add(name: str, flat: Sequence[Array] | Array, closed: bool = False, by: tuple[str, float, float] = pen) -> None:
        line = skin.line(_by_hand(np.asarray(flat), closed, random), closed)
        if len(line) < 3:
            return
        inked = np.ones(len(line), dtype=np.bool_)
        length = SPACING * len(line)
        if length > 0.06:
            for _ in range(int(random.integers(0, 3))):  # the pen skips
                first = int(random.integers(len(line)))
                inked[first : first + int(random.uniform(0.002, 0.006) / SPACING)] = False
            if random.random() < 0.15:  # dashed
                inked &= (np.arange(len(line)) * SPACING) % 0.016 < 0.010
        strokes.append(_stroke(skin, name, line, closed, by, inked))

    add("midline", [at["suprasternal_notch"], at["xiphoid"], 0.3 * at["xiphoid"] + 0.7 * at["umbilicus"]])
    for name in ("suprasternal_notch", "xiphoid"):
        if random.random() < 0.7:
            for k, arm in enumerate((np.array([0.006, 0.006]), np.array([0.006, -0.006]))):
                add(f"cross_{name}_{'ab'[k]}", [at[name] - arm, at[name] + arm])
    sides = [side for side in "LR" if f"nipple_{side}" in at and f"inframammary_fold_{side}" in at]
    for side in sides:
        nipple, fold, clavicle = at[f"nipple_{side}"], at[f"inframammary_fold_{side}"], at[f"midclavicle_{side}"]
        add(f"meridian_{side}", [clavicle, clavicle + 0.8 * (nipple - clavicle)])
        x = np.linspace(-0.05, 0.05, 21)
        add(f"imf_{side}", np.column_stack([fold[0] + x, fold[1] - 0.004 + 6.0 * x**2]))
    if plan == "none" or not sides:
        return tuple(strokes)
    side = sides[int(random.integers(len(sides)))]
    nipple, fold = at[f"nipple_{side}"], at[f"inframammary_fold_{side}"]
    turn = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    ring = np.column_stack([np.cos(turn), np.sin(turn)])
    if plan == "lumpectomy":
        angle = random.uniform(0.0, 2.0 * np.pi)
        centre = nipple + random.uniform(0.04, 0.06) * np.array([np.cos(angle), np.sin(angle)])
        add("tumour", centre + random.uniform(0.010, 0.018) * ring, True, other)
        add(f"breast_{side}", 0.5 * (nipple + fold) + np.array([0.0, 0.02]) + [0.062, 0.072] * ring, True)
    elif plan == "mastectomy":
        tilt = random.uniform(-0.5, 0.5)
        along = np.array([[np.cos(tilt), np.sin(tilt)], [-np.sin(tilt), np.cos(tilt)]])
        add(f"ellipse_{side}", nipple + ([0.065, 0.035] * ring) @ along, True)
    else:
        for each in sides:
            top = at[f"nipple_{each}"] + np.array([0.0, 0.03])
            add(f"areola_new_{each}", top + 0.021 * ring, True, other)
            low = at[f"inframammary_fold_{each}"]
            for k, out in enumerate((-1.0, 1.0)):
                leg = top + np.array([0.026 * out, -0.05])
                add(
                    f"leg_{each}_{k}",
                    [top + np.array([0.018 * out, -0.012]), leg, low + np.array([0.05 * out, 0.012])],
                    False,
                )
    return tuple(strokes)


def _by_hand(flat: Array, closed: bool, random: np.random.Generator) -> Array:
    """Corners (M, 2) as a hand draws them: a slow waver of half a millimetre."""
    line = resampled_flat(flat, 0.002, closed)
    share = np.linspace(0.0, 2.0 * np.pi, len(line), endpoint=False)
    for axis in (0, 1):
        for wave in (2, 3, 5):
            line[:, axis] += 0.0004 * random.normal() * np.cos(wave * share + random.uniform(0.0, 2.0 * np.pi))
    return line


def _unit(vector: Array) -> Array:
    return np.asarray(vector / np.linalg.norm(vector))
