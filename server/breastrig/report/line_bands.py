"""The 90 % bands of lines in pictures, as the page has them: a soft fill with a thin edge, hatched where not known."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array
from breastrig.core.srgb import Reals
from breastrig.drawings.line_error import ACROSS
from breastrig.geometry.polyline import Polyline, resampled
from breastrig.report.table import KNOWN_MM

STEP = 0.0005  # m between the points from which a pixel's distance is taken
UNKNOWN = 0.01  # m to each side that are hatched where no radius is known: as on the page
FACING = 0.2  # cosine: skin that looks another way is an arm beside the chest, or the far side of a fold; likewise
FILL, EDGE = 0.35, 0.62  # shares of the line's colour; on the page 0.24 of a darker grey
EDGE_PIXELS, HATCH_PIXELS = 1.5, 10.0  # to a line that is 4.3 pixels wide, as on the page to one of 3


@dataclass(frozen=True, eq=False)
class _Piece:
    """The places of one line of which a radius is known, or of which none is."""

    tree: cKDTree  # of N places, m
    halves: Array  # (N,) m, half the band's width
    normals: Array  # (N, 3) of the skin there
    colour: Array  # (3,)
    is_known: bool


class LineBands:
    """The bands of lines on one skin, of (S, 3) m vertices with normals; paints the pixels of a rendered scene."""

    def __init__(self, banded: Sequence[tuple[Polyline, Sequence[float]]], vertices: Array, normals: Array) -> None:
        self._pieces: list[_Piece] = []
        skin = cKDTree(vertices) if banded else None
        for line, colour in banded:
            error = np.full(len(line), np.nan) if line.error is None else np.asarray(line.error)
            half = np.where(1e3 * ACROSS * error <= KNOWN_MM, ACROSS * error, np.nan)
            places = resampled(np.column_stack([line.points, half]), STEP, line.closed)
            for is_known in (True, False):
                own = places[np.isfinite(places[:, 3]) == is_known]
                if len(own):
                    assert skin is not None
                    halves = own[:, 3] if is_known else np.full(len(own), UNKNOWN)
                    out = normals[skin.query(own[:, :3])[1]]
                    self._pieces.append(_Piece(cKDTree(own[:, :3]), halves, out, np.array(colour), is_known))

    def paint(self, colours: Reals, places: Array, normals: Reals, pixels: Array, pixel: float) -> Reals:
        """The (M, 3) colours with the bands on them."""
        depth = np.zeros(len(places))  # m inside the band in which a place lies deepest
        own = np.full(len(places), -1)
        for number, piece in enumerate(self._pieces):
            most = float(piece.halves.max())
            within = (places > piece.tree.mins - most) & (places < piece.tree.maxes + most)
            near = np.flatnonzero(within.all(axis=1))
            found = piece.tree.query(places[near], distance_upper_bound=most)
            away, at = np.asarray(found[0]), np.asarray(found[1])
            near, at, away = near[at < piece.tree.n], at[at < piece.tree.n], away[at < piece.tree.n]
            inside = piece.halves[at] - away
            facing = np.einsum("mi,mi->m", piece.normals[at], normals[near]) >= FACING
            deeper = facing & (inside > depth[near])
            depth[near[deeper]], own[near[deeper]] = inside[deeper], number
        painted = np.flatnonzero(own >= 0)
        if not len(painted):
            return colours
        edge = depth[painted] < EDGE_PIXELS * pixel
        known = np.array([piece.is_known for piece in self._pieces])[own[painted]]
        stripe = np.abs((pixels[painted].sum(axis=1) / HATCH_PIXELS) % 1.0 - 0.5) < 0.21
        share = np.where(known, np.where(edge, EDGE, FILL), np.where(stripe, EDGE, 0.0))[:, None]
        inks = np.stack([piece.colour for piece in self._pieces])[own[painted]]
        result = np.array(colours)
        result[painted] += share * (inks - result[painted])
        return result
