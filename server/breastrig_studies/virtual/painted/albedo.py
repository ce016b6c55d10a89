"""The colour of the skin itself at points of the standing skin: tone, mottling, areolae, marks, ink; no light."""

from copy import copy

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array
from breastrig_studies.virtual.painted.marks import COVERED, NATURAL, Areola, Marks, Skin, Stroke
from breastrig_studies.virtual.painted.tones import Palette

WAVES = 28  # plane waves of the mottling
WAVE_LENGTHS = (0.006, 0.07)  # m
MOTTLING = (1.5, 0.7, 0.7)  # L, a, b; standard deviation
PATCH = (0.017, 0.024)  # m, radius of what covers a nipple
NAVEL = (0.0065, 0.0095)  # m, half the width and height of a large one
NAVEL_SIZE, NAVEL_STRENGTH = (0.5, 1.1), (0.15, 0.9)  # of that; and how much of the crease's colour it shows
OFF_SKIN = 0.0025  # m off the skin, up to which an even line is seen
INK_FADES = 0.0004  # m, from full ink to none


class Albedo:
    """One patient's skin as a function of the place on it; drawn once, the same for both stances.

    `even`: lines are as dark everywhere. Otherwise they fade where a misplaced picture leaves the skin, as worn ones.
    """

    def __init__(
        self, skin: Skin, palette: Palette, marks: Marks, random: np.random.Generator, even: bool = False
    ) -> None:
        self._skin, self._palette, self._marks, self._even = skin, palette, marks, even
        length = np.exp(random.uniform(np.log(WAVE_LENGTHS[0]), np.log(WAVE_LENGTHS[1]), WAVES))
        direction = random.standard_normal((WAVES, 3))
        self._waves = 2.0 * np.pi / length[:, None] * direction / np.linalg.norm(direction, axis=1, keepdims=True)
        self._phases = random.uniform(0.0, 2.0 * np.pi, WAVES)
        self._sizes = random.standard_normal((WAVES, 3)) * MOTTLING * np.sqrt(2.0 / WAVES)
        fold = np.mean([p[1] for n, p in skin.body.landmarks.items() if n.startswith("inframammary")] or [0.3])
        self._pressure = float(fold - random.uniform(0.005, 0.03)), float(random.uniform(0.0, 4.0))
        self._navel = float(random.uniform(*NAVEL_SIZE)), float(random.uniform(*NAVEL_STRENGTH))
        self._patch = random.uniform(*PATCH), np.array([random.uniform(60.0, 85.0), random.uniform(0.0, 8.0), 12.0])

    def showing(self, marks: Marks) -> "Albedo":
        """The same skin with other marks."""
        other = copy(self)
        other._marks = marks
        return other

    def lab(self, places: Array) -> Array:
        """(N, 3) Lab at (N, 3) m, points of the standing skin."""
        colour = self._palette.skin + np.cos(places @ self._waves.T + self._phases) @ self._sizes
        height, redness = self._pressure
        band = np.exp(-0.5 * ((places[:, 1] - height) / 0.006) ** 2)
        colour += band[:, None] * np.array([-0.5, 1.0, 0.2]) * redness
        for stroke in (*self._marks.veins, *self._marks.scars):
            cover = self._cover(places, stroke, soft=0.5 * stroke.width)
            colour += (stroke.strength * cover)[:, None] * stroke.lab
        for areola in self._marks.areolae:
            self._paint_areola(colour, places, areola)
        navel = self._skin.body.landmarks.get("umbilicus")
        if navel is not None:
            size, strength = self._navel
            away = np.linalg.norm((places - navel) / np.array([size * NAVEL[0], size * NAVEL[1], 0.02]), axis=1)
            _blend(colour, self._palette.crease, strength / (1.0 + np.exp(np.minimum((away - 1.0) / 0.15, 50.0))))
        for spot in self._marks.spots:
            away = np.linalg.norm(places - spot.place, axis=1)
            _blend(colour, self._palette.mole, 0.85 / (1.0 + np.exp(np.minimum((away - spot.radius) / 0.0004, 50.0))))
        for stroke in self._marks.ink:
            _blend(colour, stroke.lab, stroke.strength * self._cover(places, stroke, INK_FADES))
        return np.asarray(colour)

    def _paint_areola(self, colour: Array, places: Array, areola: Areola) -> None:
        from_nipple = np.linalg.norm(places - areola.nipple, axis=1)
        near = np.flatnonzero(from_nipple < 0.05)
        from_nipple, part = from_nipple[near], colour[near]
        if areola.state == COVERED:
            radius, patch = self._patch
            _blend(part, patch, (from_nipple < radius).astype(np.float64))
        elif areola.state == NATURAL:
            offset = places[near] - areola.centre
            flat = offset @ areola.axes[:2].T
            beyond = np.linalg.norm(offset, axis=1) - areola.reach(np.arctan2(flat[:, 1], flat[:, 0]))
            share = 1.0 / (1.0 + np.exp(np.clip(beyond / (0.45 * areola.softness), -50.0, 50.0)))
            part += share[:, None] * (self._palette.areola - self._palette.skin)
            tip = 1.0 / (1.0 + np.exp(np.clip((from_nipple - areola.nipple_radius) / 0.0006, -50.0, 50.0)))
            part += tip[:, None] * (self._palette.nipple - self._palette.areola)
        colour[near] = part

    def _cover(self, places: Array, stroke: Stroke, soft: float) -> Array:
        """(N,) 0 to 1: how much of a place is under the stroke.

        Places lie a little off the skin (between a scan's vertices, in misplaced pictures).
        """
        points = self._skin.places(stroke.points)[stroke.inked]
        cover = np.zeros(len(places))
        if not len(points):
            return cover
        reach = 0.5 * stroke.width + 3.0 * soft
        room = float(np.hypot(reach, OFF_SKIN)) if self._even else reach
        low, high = points.min(axis=0) - room, points.max(axis=0) + room
        near = np.flatnonzero(((places > low) & (places < high)).all(axis=1))
        found = cKDTree(points).query(places[near], distance_upper_bound=room)
        distance, nearest = np.asarray(found[0]), np.asarray(found[1])
        there = np.isfinite(distance)
        near, nearest, away = near[there], nearest[there], distance[there]
        if self._even:
            off = places[near] - points[nearest]
            normals = self._skin.normals[stroke.points.faces[stroke.inked][nearest]]
            height = np.einsum("nd,nd->n", off, normals)
            aside = np.linalg.norm(off - height[:, None] * normals, axis=1)
            away = np.where(np.abs(height) < OFF_SKIN, aside, np.inf)
        cover[near] = 1.0 / (1.0 + np.exp(np.clip((away - 0.5 * stroke.width) / (0.35 * soft), -50.0, 50.0)))
        return cover


def _blend(colour: Array, other: Array, share: Array) -> None:
    colour += share[:, None] * (other - colour)
