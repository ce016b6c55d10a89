"""A small picture of the skin around one place, seen along the skin's own normal there, in Lab.

Landmarks are looked for where the geometry expects them, so one picture of a hand's width each is enough: rays along
the normal see the scan as it is there, without seams of its texture and without skin behind skin.  Within 20 mm of its
middle such a picture is true to the skin's own metric within 2 % on a breast; whoever found something farther out
looks again from there.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from breastrig.colour.skin_texture import lab
from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.normals import face_crosses, face_normals
from breastrig.geometry.rays import RayCaster
from breastrig.scan.pictures.texture import pixels_of
from breastrig.scan.scan import Scan

ABOVE = 0.06  # m over the middle, from where rays are sent
DEPTH = 0.05  # m, farther before or behind the middle is other skin
GRAZING = 0.30  # cosine; more oblique skin shows too little
NORMAL_REACH = 0.012  # m, around a place, whose triangles say where the skin looks


@dataclass(frozen=True, eq=False)
class Patch:
    """N x N pixels; row 0 is the upper one, column 0 the left one, as seen by who looks at the skin."""

    pixel: float  # m, side of a pixel
    lab: Array  # (N, N, 3) nan where no skin is seen
    places: Array  # (N, N, 3) m, on the skin, in the scan's frame; nan where none is seen
    axes: Array  # (3, 3) rows: right, up, towards the viewer; unit vectors in the scan's frame

    @cached_property
    def skin(self) -> Booleans:
        """(N, N) where skin is seen."""
        return np.isfinite(self.lab[..., 0])

    @property
    def middle(self) -> float:
        """Row and column of the patch's centre."""
        return 0.5 * (len(self.lab) - 1)

    def offsets(self) -> tuple[Array, Array]:
        """((N, N), (N, N)) m to the right of the middle, and up."""
        steps = self.pixel * (np.arange(len(self.lab)) - self.middle)
        return np.broadcast_to(steps, self.skin.shape), np.broadcast_to(-steps[:, None], self.skin.shape)

    def place(self, right: float, up: float) -> Array | None:
        """(3,) m, the skin at this offset (m) from the middle; None where none is seen near."""
        row, column = self.middle - up / self.pixel, self.middle + right / self.pixel
        low_row, low_column = int(np.floor(row)), int(np.floor(column))
        if not (0 <= low_row < len(self.lab) - 1 and 0 <= low_column < len(self.lab) - 1):
            return None
        corners = self.places[low_row : low_row + 2, low_column : low_column + 2].reshape(4, 3)
        down, across = row - low_row, column - low_column
        weights = np.array([(1 - down) * (1 - across), (1 - down) * across, down * (1 - across), down * across])
        known = np.isfinite(corners[:, 0]) & (weights > 0.0)
        if not known.any():
            return None
        return np.asarray(weights[known] @ corners[known] / weights[known].sum())


class ColouredSkin:
    """A coloured scan, prepared for pictures from any direction.

    Raises BadScan when its picture cannot be decoded.
    """

    def __init__(self, scan: Scan) -> None:
        self._scan = scan
        self._rays = RayCaster(scan.vertices, scan.faces)
        self._crosses = face_crosses(scan.vertices, scan.faces)
        self._normals = face_normals(scan.vertices, scan.faces)
        self._pixels: NDArray[np.uint8] | None = None
        if scan.colour_kind == "texture":
            assert scan.texture is not None
            self._pixels = pixels_of(scan.picture or scan.texture)

    @property
    def image(self) -> NDArray[np.uint8] | None:
        """(H, W, 3) sRGB, the decoded texture; None where vertices have the colours."""
        return self._pixels

    @cached_property
    def _middles(self) -> cKDTree:
        a, b, c = (self._scan.vertices.take(corner, axis=0) for corner in self._scan.faces.T)
        return cKDTree((a + b + c) / 3.0, balanced_tree=False, compact_nodes=False)  # asked a few times only

    def normal(self, place: Array, outwards: Array, reach: float = NORMAL_REACH) -> Array:
        """(3,) unit, where the skin looks around a place (3,) m; `outwards` says which side is outside."""
        near = np.array(self._middles.query_ball_point(place, reach, return_sorted=True), dtype=np.int64)
        crosses = self._crosses[near]
        crosses = crosses * np.where(crosses @ outwards < 0.0, -1.0, 1.0)[:, None]
        total = crosses.sum(axis=0) if len(crosses) else outwards
        return np.asarray(total / max(float(np.linalg.norm(total)), 1e-12))

    def patch(self, place: Array, normal: Array, up: Array, half: float, pixel: float) -> Patch:
        """`half` m to each side of `place` (3,) m, seen along the (3,) unit `normal`, (3,) `up` upwards."""
        right = np.cross(up, normal)
        right = right / max(float(np.linalg.norm(right)), 1e-12)
        axes = np.stack([right, np.cross(normal, right), normal])
        count = 2 * round(half / pixel) + 1
        steps = pixel * (np.arange(count) - 0.5 * (count - 1))
        across, down = np.meshgrid(steps, -steps)
        origins = place + ABOVE * normal + across.reshape(-1, 1) * axes[0] + down.reshape(-1, 1) * axes[1]
        hits = self._rays.hits(origins, np.tile(-normal, (len(origins), 1)), ABOVE + DEPTH)
        face = hits.faces
        seen = (face >= 0) & (hits.distances > ABOVE - DEPTH)
        seen &= np.abs(self._normals[face] @ normal) > GRAZING
        weights = np.stack([1.0 - hits.second - hits.third, hits.second, hits.third], axis=1)[seen]
        corners = self._scan.faces[face[seen]]
        places, colours = (np.full((count * count, 3), np.nan) for _ in range(2))
        places[seen] = np.einsum("mc,mcd->md", weights, self._scan.vertices[corners])
        if seen.any():
            colours[seen] = lab(self._colours(corners, weights)[None])[0]
        shape = (count, count, 3)
        return Patch(pixel, colours.reshape(shape), places.reshape(shape), axes)

    def _colours(self, corners: Integers, weights: Array) -> Array:
        """(M, 3) sRGB, 0 to 1."""
        if self._pixels is None:
            assert self._scan.colours is not None
            return np.asarray(np.einsum("mc,mcd->md", weights, self._scan.colours[corners] / 255.0))
        assert self._scan.uv is not None
        uv = np.einsum("mc,mcd->md", weights, self._scan.uv[corners])
        uv = uv - np.floor(uv)
        height, width = self._pixels.shape[:2]
        column = np.clip(uv[:, 0] * width - 0.5, 0.0, width - 1.001)
        row = np.clip((1.0 - uv[:, 1]) * height - 0.5, 0.0, height - 1.001)
        left, top = column.astype(np.int64), row.astype(np.int64)
        across, down = (column - left)[:, None], (row - top)[:, None]
        pixels = self._pixels
        above = (1.0 - across) * pixels[top, left] + across * pixels[top, left + 1]
        below = (1.0 - across) * pixels[top + 1, left] + across * pixels[top + 1, left + 1]
        return np.asarray(((1.0 - down) * above + down * below) / 255.0)
