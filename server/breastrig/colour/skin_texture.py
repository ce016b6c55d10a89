"""The skin's colours as a few pictures of one known scale, without the seams of the scanner's texture atlas.

The scan is projected orthographically along the six directions of its principal axes, each time with the triangles that
face within 60 degrees; skin behind other skin comes into further pictures.  Colours of vertices are treated alike.  A
pixel knows its triangle; oblique skin is shortened to half at worst, and `places` gives true ones.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadScan
from breastrig.geometry.boundary import triangle_components
from breastrig.geometry.normals import VertexNormals, face_areas, face_crosses, unit_vectors
from breastrig.scan.pictures.texture import pixels_of
from breastrig.scan.scan import Scan

TEXEL = 0.5e-3  # m; phones give 0.35 to 0.8 mm, pens draw lines of 1 to 3 mm
PIXELS = 12_000_000  # of all pictures of one scan: a torso has 4 million; larger ones are seen coarser
SMOOTHINGS = 3  # rounds over neighbours: some triangles, which are a few mm large
FACING = 0.5  # cosine of 60 degrees; no place is farther than 54.7 from its nearest axis, so neighbours overlap
LAYERS = 2  # further pictures of one direction; skin behind skin behind skin
PART_AREA = 1e-4  # m², a square centimetre of hidden skin
HIDDEN = 0.5  # share of a triangle's pixels that others cover, from which it comes into the next layer
EPSILON = 1e-6  # pixels
FARTHEST = 1e6  # pictures to the side; texture coordinates beyond are none


@dataclass(frozen=True, eq=False)
class SkinPicture:
    """H by W pixels of the skin, seen along one direction; row 0 is the upper one."""

    pixels: NDArray[np.uint8]  # (H, W, 3) sRGB; black where there is no skin
    faces: NDArray[np.int32]  # (H, W) triangle of the scan at the pixel's middle, -1 where there is none
    texel: float  # m, side of a pixel
    axes: Array  # (3, 3) rows: right, down, away from the viewer; unit vectors in the scan's frame
    corner: Array  # (3,) m, the middle of pixel (0, 0) at depth 0, in the scan's frame
    _shown: Integers  # (N,) triangles of the scan that may be seen here
    _plane: Array  # (N, 3) pixels: depth of a triangle's plane = plane · (column, row, 1)

    @property
    def skin(self) -> Booleans:
        """(H, W) where there is skin."""
        return self.faces >= 0

    @cached_property
    def _number(self) -> Integers:
        number = np.zeros(int(self._shown.max()) + 1, dtype=np.int64)
        number[self._shown] = np.arange(len(self._shown))
        return number

    def depths(self, rows: Array | Integers, columns: Array | Integers, faces: Integers) -> Array:
        """(M,) pixels away from the viewer, at (M,) rows and columns on the planes of (M,) triangles."""
        plane = self._plane[self._number[faces]]
        return np.asarray(plane[:, 0] * columns + plane[:, 1] * rows + plane[:, 2])

    def places(self, rows: Array | Integers, columns: Array | Integers, faces: Integers | None = None) -> Array:
        """(M, 3) m places on the skin, in the scan's frame, of (M,) rows and columns, fractions of pixels too.

        `faces` (M,) are the triangles whose planes they lie on, by default those of the nearest pixels, which must
        show skin.
        """
        if faces is None:
            faces = self.faces[np.rint(rows).astype(np.int64), np.rint(columns).astype(np.int64)].astype(np.int64)
        seen = np.stack([columns, rows, self.depths(rows, columns, faces)], axis=1)
        return np.asarray(self.corner + self.texel * seen @ self.axes)


@dataclass(frozen=True, eq=False)
class SkinTexture:
    """All pictures of one scan, and their common data."""

    scan: Scan
    pictures: tuple[SkinPicture, ...]
    owner: Integers  # (F,) number of the picture that sees a triangle best, -1 for what none shows
    node: Integers  # (V,) the scan's vertices as nodes of its skin: vertices at one place, along seams, are one
    face_colours: NDArray[np.uint8]  # (F, 3) sRGB in the middle of each triangle of the scan
    source_texel: float  # m, how far apart the scanner's own texels or coloured vertices are, median


def lab(pixels: NDArray[np.uint8] | Array) -> Array:
    """(..., 3) CIE Lab (D65) of (..., 3) sRGB, bytes or 0 to 1; L from 0 to 100."""
    from skimage.color import rgb2lab  # it takes 0.3 s to load, and most scans need it not

    return np.asarray(rgb2lab(pixels), dtype=np.float64)


def skin_texture(scan: Scan, texel: float = TEXEL, image: NDArray[np.uint8] | None = None) -> SkinTexture:
    """The pictures of a coloured scan; `texel` (m) is the side of their pixels, larger for a very large scan.

    `image` (H, W, 3) sRGB is its texture where that is decoded already.

    Raises BadScan, with one sentence, for a scan without colour or one whose picture cannot be decoded.
    """
    if scan.colour_kind == "none":
        raise BadScan("This scan has no colour; scan again with colour, and export it with its texture.")
    source = _TextureSource(scan, image) if scan.colour_kind == "texture" else _VertexSource(scan)
    node = welded(scan.vertices)
    axes = _principal_axes(scan)
    used = np.zeros(len(scan.vertices), dtype=np.bool_)
    used[scan.faces.ravel()] = True
    span = np.ptp(scan.vertices[used] @ axes.T, axis=0)
    area = 2.0 * (span[0] * span[1] + span[1] * span[2] + span[2] * span[0])
    texel = max(texel, float(np.sqrt(area / PIXELS)))
    turns = _smooth_normals(scan, node)
    pictures = []
    directions = [_view(axes, axis, sign) for axis in range(3) for sign in (1.0, -1.0)]
    facing = np.stack([turns @ -view[2] for view in directions], axis=1)
    owner, best = np.full(len(scan.faces), -1), np.zeros(len(scan.faces))
    for number, view in enumerate(directions):
        found, shown = _seen_along(scan, source, np.flatnonzero(facing[:, number] >= FACING), view, texel)
        pictures += found
        better = shown[facing[shown, number] > best[shown]]
        owner[better], best[better] = len(pictures) - 1, facing[better, number]
    nearest = facing.argmax(axis=1)
    for number, view in enumerate(directions):
        for _ in range(LAYERS):
            for part in _parts(scan, node, np.flatnonzero((owner < 0) & (nearest == number))):
                found, shown = _seen_along(scan, source, part, view, texel)
                pictures += found
                owner[shown] = len(pictures) - 1
    return SkinTexture(scan, tuple(pictures), owner, node, source.middles(), source.texel)


def welded(vertices: Array, within: float = 1e-6) -> Integers:
    """(V,) numbers of (V, 3) m vertices, equal for those at one place (m)."""
    keys = np.rint(vertices / within).astype(np.int64)
    order = np.lexsort(keys.T)
    new = np.concatenate([[False], (np.diff(keys[order], axis=0) != 0).any(axis=1)])
    number = np.zeros(len(vertices), dtype=np.int64)
    number[order] = np.cumsum(new)
    return number


def _principal_axes(scan: Scan) -> Array:
    """(3, 3) rows: principal axes, longest first."""
    a, b, c = (scan.vertices.take(corner, axis=0) for corner in scan.faces.T)
    middles = (a + b + c) / 3.0
    off = middles - middles.mean(axis=0)
    return np.asarray(np.linalg.eigh(off.T @ off)[1].T[::-1])


def _smooth_normals(scan: Scan, node: Integers) -> Array:
    """(F, 3) where each triangle faces without the scanner's noise, which would fray the pictures' edges."""
    corners = node[scan.faces]
    incidence = VertexNormals(corners, int(node.max()) + 1)
    normals = face_crosses(scan.vertices, scan.faces)
    for _ in range(SMOOTHINGS):
        around = incidence.summed(normals)
        normals = around[corners[:, 0]] + around[corners[:, 1]] + around[corners[:, 2]]
    return unit_vectors(normals)


def _view(axes: Array, axis: int, sign: float) -> Array:
    """(3, 3) rows: right, down, away from a viewer who sees the skin whose normals point along sign · axis."""
    away = -sign * axes[axis]
    down = axes[(axis + 1) % 3]
    return np.stack([np.cross(down, away), down, away])


def _parts(scan: Scan, node: Integers, faces: Integers) -> list[Integers]:
    """The connected parts of some triangles, each a small picture; without those too small to show anything."""
    corners = node[scan.faces[faces]]
    _, label = triangle_components(corners, int(node.max()) + 1)
    areas = face_areas(scan.vertices, scan.faces[faces])
    part = np.unique(label[corners[:, 0]], return_inverse=True)[1]
    large = np.bincount(part, areas) >= PART_AREA
    return [faces[part == each] for each in np.flatnonzero(large)]


def _seen_along(
    scan: Scan, source: "_TextureSource | _VertexSource", wanted: Integers, axes: Array, texel: float
) -> tuple[list[SkinPicture], Integers]:
    """(The picture of the triangles that are wanted, if it shows any, and those that it does not hide)."""
    if not len(wanted):
        return [], wanted
    seen = scan.vertices @ (axes.T / texel)  # (V, 3) pixels
    depths = np.ascontiguousarray(seen[:, 2])
    a, b, c = scan.faces[wanted].T
    far_first = np.argsort(-(depths[a] + depths[b] + depths[c]), kind="stable")  # the nearest is painted last
    wanted = wanted[far_first]
    corners = seen[scan.faces[wanted]]  # (N, 3, 3)
    places = corners.reshape(-1, 3)
    low = np.array([np.floor(places[:, axis].min()) - 1.0 for axis in range(2)])
    width, height = (int(np.ceil(places[:, axis].max()) + 2.0 - low[axis]) for axis in range(2))
    flat = corners[:, :, :2] - low
    which, cells = _covered(flat, width)
    painted = np.full(height * width, -1, dtype=np.int32)
    painted[cells] = which
    at = np.flatnonzero(painted >= 0)
    if not len(at):
        return [], wanted
    index = painted[at]
    row, column = np.divmod(at.astype(np.int32), np.int32(width))
    pixels = np.zeros((len(painted), 3), dtype=np.uint8)
    pixels[at] = source.colours(wanted, flat, index, column.astype(np.float32), row.astype(np.float32))
    faces = painted.copy()
    faces[at] = wanted.astype(np.int32)[index]
    covers = np.bincount(which, minlength=len(wanted))
    shown = wanted[np.bincount(index, minlength=len(wanted)) >= HIDDEN * covers]
    picture = SkinPicture(
        pixels.reshape(height, width, 3),
        faces.reshape(height, width),
        texel,
        axes,
        texel * np.array([low[0], low[1], 0.0]) @ axes,
        wanted,
        _affine(flat, corners[:, :, 2:])[:, :, 0],
    )
    return [picture], shown


def _covered(corners: Array, width: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """((M,) triangle, (M,) cell = row · width + column): which pixels' middles lie in (N, 3, 2) triangles.

    Line by line: where the triangle's edges cut a row of pixels, and all between.
    """
    x, y = (np.ascontiguousarray(corners[:, :, axis].T) for axis in range(2))
    first = np.ceil(y.min(axis=0) - EPSILON).astype(np.int32)
    rows = np.maximum(np.floor(y.max(axis=0) + EPSILON).astype(np.int32) - first + 1, 0)
    span, number = _counted(rows)
    row = first[span] + number
    left, right = np.full(len(span), np.inf), np.full(len(span), -np.inf)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        rise = y[b] - y[a]
        slope = (x[b] - x[a]) / np.where(np.abs(rise) < EPSILON, np.inf, rise)
        across = (x[a] - slope * y[a])[span] + slope[span] * row
        on = row >= (np.minimum(y[a], y[b]) - EPSILON)[span]
        on &= row <= (np.maximum(y[a], y[b]) + EPSILON)[span]
        np.minimum(left, across, out=left, where=on)
        np.maximum(right, across, out=right, where=on)
    np.clip(left, -1.0, width, out=left)
    np.clip(right, -1.0, width, out=right)
    start = np.ceil(left - EPSILON).astype(np.int32)
    run, along = _counted(np.maximum(np.floor(right + EPSILON).astype(np.int32) - start + 1, 0))
    return span[run], (row * np.int32(width) + start)[run] + along


def _counted(counts: NDArray[np.int32]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """((M,) owner, (M,) its own count from 0) for owners that have so many."""
    owner = np.repeat(np.arange(len(counts), dtype=np.int32), counts)
    along = np.arange(len(owner), dtype=np.int32)
    along -= np.repeat(np.cumsum(counts, dtype=np.int32) - counts, counts)
    return owner, along


def _affine(corners: Array, values: Array) -> Array:
    """(N, 3, K) coefficients of column, row and 1 that give (N, 3, K) values at the corners (N, 3, 2)."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    ab, ac = b - a, c - a
    area = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    flat = np.abs(area) < EPSILON
    area = np.where(flat, 1.0, area)[:, None]
    vb, vc = values[:, 1] - values[:, 0], values[:, 2] - values[:, 0]
    by_column = np.where(flat[:, None], 0.0, (ac[:, 1:] * vb - ab[:, 1:] * vc) / area)
    by_row = np.where(flat[:, None], 0.0, (ab[:, :1] * vc - ac[:, :1] * vb) / area)
    rest = values[:, 0] - by_column * a[:, :1] - by_row * a[:, 1:]
    return np.stack([by_column, by_row, rest], axis=1)


class _TextureSource:
    """Colours from the scanner's atlas, its texels as they are: filters smooth later."""

    def __init__(self, scan: Scan, image: NDArray[np.uint8] | None) -> None:
        assert scan.uv is not None
        assert scan.texture is not None
        image = pixels_of(scan.picture or scan.texture) if image is None else image
        height, width = image.shape[:2]
        self._pixels = image.reshape(-1, 3)
        self._size = (width, height)
        uv = np.clip(scan.uv, -FARTHEST, FARTHEST)[scan.faces]
        uv = uv - np.floor((uv[:, :1] + uv[:, 1:2] + uv[:, 2:]) / 3.0)  # textures repeat beyond 0 and 1
        self._at = np.stack([uv[:, :, 0] * width - 0.5, (1.0 - uv[:, :, 1]) * height - 0.5], axis=2)
        self.texel = _size_of_texels(scan, self._at)

    def colours(
        self,
        faces: Integers,
        corners: Array,
        index: NDArray[np.int32],
        columns: NDArray[np.float32],
        rows: NDArray[np.float32],
    ) -> NDArray[np.uint8]:
        """(M, 3) sRGB at (M,) columns and rows of triangles `faces[index]`, their (N, 3, 2) corners there."""
        by = _affine(corners, self._at[faces])
        by[:, 2] += 0.5  # so that cutting off rounds
        by = np.ascontiguousarray(by.transpose(2, 1, 0), dtype=np.float32)
        cells = np.zeros(len(index), dtype=np.int32)
        for axis, stride in ((0, 1), (1, self._size[0])):
            at = by[axis, 0].take(index)
            at *= columns
            at += by[axis, 1].take(index) * rows
            at += by[axis, 2].take(index)
            np.clip(at, 0.0, self._size[axis] - 1, out=at)
            cells += at.astype(np.int32) * np.int32(stride)
        return self._pixels.take(cells, axis=0)

    def middles(self) -> NDArray[np.uint8]:
        """(F, 3) sRGB in the middle of each triangle."""
        at = np.rint((self._at[:, 0] + self._at[:, 1] + self._at[:, 2]) / 3.0)
        column, row = (np.clip(at[:, axis], 0, self._size[axis] - 1).astype(np.int64) for axis in range(2))
        found: NDArray[np.uint8] = self._pixels.take(row * self._size[0] + column, axis=0)
        return found


class _VertexSource:
    """Colours of vertices, mixed across triangles."""

    def __init__(self, scan: Scan) -> None:
        assert scan.colours is not None
        self._values = scan.colours[scan.faces].astype(np.float64)
        ends = scan.vertices[scan.faces]
        self.texel = float(np.median(np.linalg.norm(ends - np.roll(ends, 1, axis=1), axis=2)))

    def colours(
        self,
        faces: Integers,
        corners: Array,
        index: NDArray[np.int32],
        columns: NDArray[np.float32],
        rows: NDArray[np.float32],
    ) -> NDArray[np.uint8]:
        """(M, 3) sRGB at (M,) columns and rows of triangles `faces[index]`, their (N, 3, 2) corners there."""
        by = _affine(corners, self._values[faces]).astype(np.float32)
        at = by[index, 0] * columns[:, None] + by[index, 1] * rows[:, None] + by[index, 2]
        found: NDArray[np.uint8] = np.clip(np.rint(at), 0, 255).astype(np.uint8)
        return found

    def middles(self) -> NDArray[np.uint8]:
        """(F, 3) sRGB in the middle of each triangle."""
        mixed: NDArray[np.uint8] = np.rint(self._values.mean(axis=1)).astype(np.uint8)
        return mixed


def _size_of_texels(scan: Scan, at: Array) -> float:
    """m, the median side of the texels (F, 3, 2) on the skin."""
    corners = scan.vertices[scan.faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    ab, ac = at[:, 1] - at[:, 0], at[:, 2] - at[:, 0]
    texels = np.abs(ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0])
    sound = (texels > EPSILON) & (area > 0.0)
    return float(np.sqrt(np.median(area[sound] / texels[sound]))) if sound.any() else np.inf
