"""Small marks on a painted patient: dots and crosses of a pen and moles, on both scans, and where they truly are."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from breastrig.core.arrays import Array
from breastrig.geometry.surface_points import SurfacePoints
from breastrig_studies.virtual.painted.make import PaintedSkin
from breastrig_studies.virtual.painted.marks import Skin, Spot, Stroke
from breastrig_studies.virtual.painted.tones import INKS

COUNTS = {"dot": 6, "cross": 4, "mole": 5}
CHEST = 0.13  # m from the line between the nipples
OFF_NIPPLE, APART = 0.032, 0.020  # m
DOT = (0.0025, 0.0045)  # m, across
ARM, PEN = (0.0035, 0.006), (0.0010, 0.0020)  # m: half the length of a cross, its lines' width
MOLE = (0.0012, 0.0038)  # m, radius
LEAST = 0.001  # m, radius of what of a mole is seen; smaller ones are freckles


@dataclass(frozen=True)
class SmallMark:
    """A mark and its true place on the skin."""

    kind: str  # dot | cross | mole
    place: SurfacePoints  # one point
    size: float  # m, across


def draw_small(skin: Skin, random: np.random.Generator) -> tuple[list[SmallMark], list[Stroke], list[Spot]]:
    """Marks far from the nipples and from each other, all of one ink, and what is painted of them."""
    body = skin.body
    left, right = (body.landmarks[f"nipple_{side}"] for side in "LR")
    across = right - left
    share = np.clip((skin.vertices - left) @ across / (across @ across), 0.0, 1.0)
    near = np.linalg.norm(skin.vertices - left - share[:, None] * across, axis=1) < CHEST
    near &= (skin.vertices[:, 2] > 0.0) & (body.landmarks["suprasternal_notch"][1] > skin.vertices[:, 1])
    taken = [left, right]
    ink = str(random.choice(list(INKS)))
    color, lab = INKS[ink]
    marks, strokes, spots = list[SmallMark](), list[Stroke](), list[Spot]()
    for kind in (kind for kind, count in COUNTS.items() for _ in range(count)):
        far = near & (np.linalg.norm(skin.vertices - taken[0], axis=1) > OFF_NIPPLE)
        for number, other in enumerate(taken):
            far &= np.linalg.norm(skin.vertices - other, axis=1) > (OFF_NIPPLE if number < 2 else APART)
        place = skin.vertices[int(random.choice(np.flatnonzero(far)))]
        taken.append(place)
        at = skin.nearest(place[None])
        if kind == "mole":
            radius = float(random.uniform(*MOLE))
            spots.append(Spot(place, radius))
            marks.append(SmallMark(kind, at, 2.0 * radius))
            continue
        normal: Array = skin.normals[at.faces[0]]
        first: Array = np.cross(normal, random.standard_normal(3))
        first /= np.linalg.norm(first)
        strength = float(random.uniform(0.6, 0.92))
        if kind == "dot":
            width = float(random.uniform(*DOT))
            lines, size = [place + np.outer([-2e-4, 2e-4], first)], width
        else:
            half, width = float(random.uniform(*ARM)), float(random.uniform(*PEN))
            steps, size = np.arange(-half, half, 4e-4), 2.0 * half
            lines = [place + np.outer(steps, each) for each in (first, np.cross(normal, first))]
        for line in lines:
            points = skin.nearest(line)
            drawn = np.ones(len(line), dtype=np.bool_)
            strokes.append(Stroke(f"{kind}_{len(marks)}", False, color, np.array(lab), width, strength, points, drawn))
        marks.append(SmallMark(kind, at, size))
    return marks, strokes, spots


def seen_moles(skin: Skin, spots: tuple[Spot, ...]) -> list[SmallMark]:
    """The moles that are drawn anyway: their middles lie off the skin, so that smaller ones are seen, or none."""
    found = []
    for spot in spots:
        at = skin.nearest(spot.place[None])
        gap: Array = skin.places(at)[0] - spot.place
        seen = max(spot.radius**2 - float(gap @ gap), 0.0) ** 0.5
        if seen > 0.0:
            found.append(SmallMark("mole" if seen >= LEAST else "freckle", at, 2.0 * seen))
    return found


def with_small(
    painted: PaintedSkin, random: np.random.Generator
) -> tuple[PaintedSkin, PaintedSkin, tuple[SmallMark, ...]]:
    """The skin with the plan's lines and the marks, the same with the marks alone, and all marks that it has."""
    marks, strokes, spots = draw_small(painted.skin, random)
    moles = (*painted.marks.spots, *spots)

    def drawn(ink: Sequence[Stroke]) -> PaintedSkin:
        own = replace(painted.marks, ink=tuple(ink), spots=moles)
        return replace(painted, marks=own, albedo=painted.albedo.showing(own))

    every = (*marks, *seen_moles(painted.skin, painted.marks.spots))
    return drawn([*painted.marks.ink, *strokes]), drawn(strokes), every
