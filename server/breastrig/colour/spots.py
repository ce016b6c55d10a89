"""Small marks on the skin of a coloured scan: dots and crosses of a pen, and moles.

Candidates are small both ways: they differ from a Gaussian mean around them in optical density or its hue, at one of
four sizes.  Each is then seen along the skin's own normal, in Lab against the skin around.  What is drawn out, goes on
(lines, hair, folds) or is large (areolae, shade) is none.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.ndimage import gaussian_filter, label, maximum_filter

from breastrig.colour.features.patch import ColouredSkin, Patch
from breastrig.colour.ink.find_ink import fine_texture
from breastrig.colour.ink.ridges import DENSITY, SHARE, darkening, hue_of
from breastrig.colour.skin_texture import SkinPicture
from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.normals import face_normals
from breastrig.scan.scan import Scan

PEN, CROSS, MOLE = "dot", "cross", "mole"

SCALES = (0.5e-3, 0.8e-3, 1.3e-3, 2.1e-3, 3.4e-3)  # m, standard deviations: dots of 1.5 to 7 mm
WEAK = 0.06  # density by which a candidate differs; the smallest moles that count have 0.1
APART = 1.5e-3  # m between two candidates
ON_SKIN = 0.8  # share of the widest mean that must lie on skin
MOST = 2000  # candidates, the strongest; a torso has 60 to 250
HALF, PIXEL, NORMAL = 11e-3, 0.4e-3, 6e-3  # m, of the picture along the normal, and around what the normal is taken
CORE, RING = 1.2e-3, 7e-3  # m from the middle: the spot's own colour, and beyond which the skin's
SHOWN = 0.6  # share of the ring that the scan must show

# Chosen on eight painted women of the development half (docs/decisions/0036)
CONTRAST, LEAST = 0.13, 5.0  # Lab for each L of the skin, and at least: less are grain, freckles and shade
CLEAR = 3.0  # times the scatter of the skin around; shade has up to 2
SMALLEST, LARGEST = 1.8e-3, 8.5e-3  # m, diameters by area; blur makes a mole of 2 to 8 mm so large
REACH = 9.5e-3  # m from the middle to the ends of a cross
ROUND, CROSS_ROUND = 0.5, 0.7  # shorter over longer axis
FULL = 0.85  # share of the convex hull; the arms of a cross leave it emptier
ALIKE = 0.08  # share of the ring at most that has the spot's colour, too: a line or an edge goes on there
BLUER, COLOURED = 0.18, 0.5  # of the difference: towards blue, and to green or red, is a pen; else a mole
SAME = 4e-3  # m between two findings of one mark


@dataclass(frozen=True, eq=False)
class ColourSpot:
    """A small mark."""

    place: Array  # (3,) m on the skin, in the scan's frame
    kind: str  # dot | cross | mole
    size: float  # m, of the circle of its area
    colour: Array  # (3,) Lab, from the skin around to it

    @property
    def contrast(self) -> float:
        """Lab."""
        return float(np.linalg.norm(self.colour))


def find_spots(scan: Scan) -> tuple[ColourSpot, ...]:
    """All small marks on a coloured scan, clearest first; those that are drawn on an areola, a navel or a plan, too.

    Raises BadScan, with one sentence, for a scan without colour or with colours too coarse.
    """
    texture = fine_texture(scan)
    found = [_candidates(picture, texture.owner == number) for number, picture in enumerate(texture.pictures)]
    if not found:
        return ()
    places, faces, heights = (np.concatenate(each) for each in zip(*found, strict=True))
    skin, normals = ColouredSkin(scan), face_normals(scan.vertices, scan.faces)
    order = np.argsort(-heights)[:MOST]
    spots = [_measured(skin, place, normals[face]) for place, face in zip(places[order], faces[order], strict=True)]
    clear = sorted((spot for spot in spots if spot is not None), key=lambda spot: -spot.contrast)
    kept: list[ColourSpot] = []
    for spot in clear:
        if all(np.linalg.norm(spot.place - other.place) > SAME for other in kept):
            kept.append(spot)
    return tuple(kept)


def _candidates(picture: SkinPicture, own: Booleans) -> tuple[Array, Integers, Array]:
    """((M, 3) m places, (M,) triangles, (M,) densities) of small things on a picture's own triangles (F,)."""
    skin, density = picture.skin, DENSITY.take(picture.pixels)
    sigmas = [scale / picture.texel for scale in SCALES]
    weights = [gaussian_filter(skin.astype(np.float32), sigma, truncate=3.0) for sigma in sigmas]
    best = np.zeros(skin.shape, dtype=np.float32)
    for signal, both in ((darkening(density), False), (hue_of(density), True)):
        means = [
            gaussian_filter(signal * skin, sigma, truncate=3.0) / np.maximum(weight, SHARE)
            for sigma, weight in zip(sigmas, weights, strict=True)
        ]
        for fine, coarse in pairwise(means):
            np.maximum(best, np.abs(fine - coarse) if both else fine - coarse, out=best)
    tops = (best == maximum_filter(best, 2 * round(APART / picture.texel) + 1)) & (best > WEAK)
    rows, columns = np.nonzero(tops & skin & (weights[-1] > ON_SKIN))
    faces = picture.faces[rows, columns].astype(np.int64)
    mine = own[faces]
    rows, columns, faces = rows[mine], columns[mine], faces[mine]
    return picture.places(rows, columns, faces), faces, best[rows, columns].astype(np.float64)


def _measured(skin: ColouredSkin, place: Array, outwards: Array) -> ColourSpot | None:
    """The mark at a (3,) m place of skin that looks (3,) `outwards`, or None."""
    normal = skin.normal(place, outwards, NORMAL)
    patch = skin.patch(place, normal, np.eye(3)[int(np.abs(normal).argmin())], HALF, PIXEL)
    away, known = np.hypot(*patch.offsets()), patch.skin
    ring, core = known & (away > RING), known & (away < CORE)
    if ring.sum() < SHOWN * (away > RING).sum() or not core.any():
        return None
    around = np.median(patch.lab[ring], axis=0)
    step = np.median(patch.lab[core], axis=0) - around
    contrast = float(np.linalg.norm(step))
    if contrast < max(CONTRAST * around[0], LEAST):
        return None
    share = np.where(known, (patch.lab - around) @ step / contrast**2, 0.0)  # 1 as the spot, 0 as the skin
    if np.sqrt(np.mean(share[ring] ** 2)) * CLEAR > 1.0 or (share[ring] > 0.5).mean() > ALIKE:
        return None
    return _of_form(patch, share > 0.5, around)


def _of_form(patch: Patch, coloured: Booleans, around: Array) -> ColourSpot | None:
    """The mark whose colour (N, N) `coloured` has in the middle of a patch, if it has the form of one."""
    from skimage.measure import regionprops  # it takes 0.3 s to load, and most scans need it not

    parts, _ = label(coloured)
    middle = len(coloured) // 2
    number = parts[middle, middle]
    if not number:
        return None
    inside = parts == number
    [region] = regionprops(inside.astype(np.uint8))
    size = patch.pixel * float(np.sqrt(4.0 / np.pi * region.area))
    off = patch.pixel * (np.argwhere(inside) - region.centroid)
    reach = float(np.hypot(*off.T).max())
    is_cross = region.solidity < FULL
    if size < SMALLEST or reach > REACH or (size > LARGEST and not is_cross):
        return None
    if region.axis_minor_length < (CROSS_ROUND if is_cross else ROUND) * region.axis_major_length:
        return None
    colour = np.median(patch.lab[inside], axis=0) - around
    if np.linalg.norm(colour) < max(CONTRAST * around[0], LEAST):
        return None
    row, column = region.centroid
    place = patch.place(patch.pixel * (column - patch.middle), patch.pixel * (patch.middle - row))
    if place is None:
        return None
    _, green, blue = colour / float(np.linalg.norm(colour))
    kind = CROSS if is_cross else PEN if blue < -BLUER or abs(green) > COLOURED else MOLE
    return ColourSpot(place, kind, size, colour)
