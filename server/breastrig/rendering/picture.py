"""Shaded pictures of meshes without a display: one Embree ray a pixel, four where the picture has an edge.

For contact sheets, evaluations and reports.  Orthographic, so that lengths in the picture are lengths on the
body; lit from the front and upper left of the viewer with a fill and a rim, which shows the form of soft skin
better than a light at the eye.  The inside of an open surface is drawn grey.  640 x 640 pixels of a scan of
50,000 triangles take about a fifth of a second.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadSettings, unknown_name
from breastrig.core.srgb import Reals, to_light, to_srgb
from breastrig.geometry.normals import face_normals, vertex_normals
from breastrig.geometry.rays import RayCaster

Picture: TypeAlias = NDArray[np.uint8]  # (H, W, 3), or (H, W, 4) without background
Colour: TypeAlias = tuple[float, float, float]  # red green blue, 0 to 1, as on the screen (sRGB)
# (M, 3) colours of places on the skin: from these colours, the places (M, 3) m, their (M, 3) normals, where they are in
# the picture in (M, 2) pixels, and how large a pixel is, m
Paint: TypeAlias = Callable[[Reals, Array, Reals, Array, float], Reals]

NEUTRAL: Colour = (0.80, 0.78, 0.76)
WHITE: Colour = (1.0, 1.0, 1.0)
INSIDE: Colour = (0.45, 0.47, 0.50)  # the back of an open surface

# (direction in the viewer's right/up/towards axes, strength): key, fill, rim
LIGHTS = (((-0.55, 0.62, 0.56), 0.74), ((0.75, 0.10, 0.65), 0.16), ((0.55, 0.55, -0.62), 0.28))
AMBIENT = 0.20
EDGE_DEPTH = 0.006  # m, neighbouring pixels further apart in depth are an outline
EDGE_TURN = 0.95  # cosine between the normals of neighbouring pixels below which the pixel is refined
NOISE_MM = 2.0  # of a depth camera; no colour of the distances is spent on less
FIRST_STEP = 0.18  # share of the full colour with which the colours of the distances begin beyond the noise
LINE_TOLERANCE = 0.004  # m, a line this far behind the surface is still drawn: lines lie on coarser surfaces
LINE_OVERSAMPLING = 3  # lines are drawn this much larger, then reduced

# direction towards the viewer and up, in the body frame (+X patient's left, +Y head, +Z front)
VIEWS: dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "front": ((0, 0, 1), (0, 1, 0)),
    "left": ((1, 0, 0), (0, 1, 0)),
    "right": ((-1, 0, 0), (0, 1, 0)),
    "back": ((0, 0, -1), (0, 1, 0)),
    "three_quarter": ((0.58, 0.16, 0.80), (0, 1, 0)),
    "three_quarter_right": ((-0.58, 0.16, 0.80), (0, 1, 0)),
    "top": ((0, 1, 0), (0, 0, -1)),
    "below": ((0, -1, 0), (0, 0, 1)),
}


@dataclass(frozen=True, eq=False)
class Layer:
    """One mesh of the picture."""

    vertices: Array  # (V, 3) m
    faces: Integers  # (F, 3) counter-clockwise from outside
    colours: Array | Colour = NEUTRAL  # (V, 3) or one colour, 0 to 1


@dataclass(frozen=True, eq=False)
class Line:
    """A polyline on top of the meshes, hidden where they stand before it; a single point is a dot."""

    points: Array  # (M, 3) m
    colour: Colour
    width: float = 2.0  # pixels
    closed: bool = False


@dataclass(frozen=True, eq=False)
class Camera:
    """An orthographic view."""

    centre: Array  # (3,) m, shown in the middle of the picture
    axes: Array  # (3, 3), rows: right, up, towards the viewer; unit
    height: float  # m shown from the lower to the upper edge


def camera(view: str, points: Array, frame: Array | None = None, aspect: float = 1.0, margin: float = 0.04) -> Camera:
    """The named view that frames (M, 3) m points; BadSettings on a wrong name.

    `frame` (3, 3) holds the body's left, up and front directions as columns, when they are not X, Y, Z;
    `aspect` is width / height of the picture; `margin` is left free on each side, as a share of the picture.
    """
    if view not in VIEWS:
        raise BadSettings(unknown_name("view", view, tuple(VIEWS)))
    towards, up = (np.asarray(axis, dtype=np.float64) for axis in VIEWS[view])
    towards = towards / np.linalg.norm(towards)
    right = np.cross(up, towards)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(towards, right), towards])
    if frame is not None:
        axes = axes @ frame.T
    seen = points @ axes.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    extent = np.maximum(high - low, 1e-6)
    height = max(extent[1], extent[0] / aspect) / (1.0 - 2.0 * margin)
    return Camera(0.5 * (low + high) @ axes, axes, float(height))


class Scene:
    """Meshes made ready for several pictures; `rays` of them all, where there are some already."""

    def __init__(self, layers: Sequence[Layer], rays: RayCaster | None = None) -> None:
        offsets = np.cumsum([0, *(len(layer.vertices) for layer in layers)])
        self._vertices = np.concatenate([np.zeros((0, 3)), *(layer.vertices for layer in layers)])
        self._faces = np.concatenate(
            [np.zeros((0, 3), dtype=np.int64)]
            + [layer.faces + start for layer, start in zip(layers, offsets[:-1], strict=True)]
        )
        self._colours = np.concatenate(
            [np.zeros((0, 3))] + [np.broadcast_to(np.asarray(layer.colours), layer.vertices.shape) for layer in layers]
        )
        # What is mixed for each pixel has the precision of the rays: of 30,000 values one is a step of 255 off by it.
        self._colours = self._colours.astype(np.float32)
        self._flat = face_normals(self._vertices, self._faces).astype(np.float32)
        self._normals = vertex_normals(self._vertices, self._faces).astype(np.float32)
        self._rays = rays or RayCaster(self._vertices, self._faces)

    def render(
        self,
        view: Camera,
        size: tuple[int, int] = (640, 640),
        lines: Sequence[Line] = (),
        background: Colour | None = WHITE,
        paint: Paint | None = None,
    ) -> Picture:
        """(H, W, 3) picture of `size` (width, height) pixels; (H, W, 4) with alpha when `background` is None.

        `paint` colours the meshes' outside, pixel by pixel, before light falls on it.
        """
        width, height = size
        pixel = view.height / height
        row, column = np.divmod(np.arange(width * height), width)
        x, y = (column + 0.5 - width / 2) * pixel, (height / 2 - row - 0.5) * pixel
        seen = (self._vertices - view.centre) @ view.axes.T
        box = np.stack([seen.min(axis=0), seen.max(axis=0)]) if len(seen) else np.zeros((2, 3))
        colour, depth, normal = self._shaded(view, box, x, y, pixel, paint)
        index = np.flatnonzero(_edges(depth.reshape(height, width), normal.reshape(height, width, 3)))
        if len(index):
            total = np.zeros((len(index), 4))
            for dx, dy in ((-0.125, -0.375), (0.375, -0.125), (-0.375, 0.125), (0.125, 0.375)):
                total += self._shaded(view, box, x[index] + dx * pixel, y[index] + dy * pixel, pixel, paint)[0]
            colour[index] = total / 4.0
        for line in lines:
            _draw(colour, depth, line, view, size)
        if background is None:
            colour[:, :3] /= np.maximum(colour[:, 3:], 1e-9)
        else:
            colour = colour[:, :3] + (1.0 - colour[:, 3:]) * np.asarray(background)
        return np.asarray(np.rint(255.0 * np.clip(colour, 0.0, 1.0)), dtype=np.uint8).reshape(height, width, -1)

    def _shaded(
        self, view: Camera, box: Array, x: Array, y: Array, pixel: float, paint: Paint | None
    ) -> tuple[Array, Array, Array]:
        """(M, 4) colour times alpha, (M,) depth towards the viewer or -inf, (M, 3) normal in the viewer's axes.

        box: (2, 3) m, the least and most of all vertices in the viewer's axes.
        """
        count = len(x)
        colour, depth, normal = np.zeros((count, 4)), np.full(count, -np.inf), np.zeros((count, 3))
        if len(self._faces) == 0:
            return colour, depth, normal
        low, high = box
        index = np.flatnonzero(
            (x > low[0] - pixel) & (x < high[0] + pixel) & (y > low[1] - pixel) & (y < high[1] + pixel)
        )
        start = high[2] + 0.01
        at = np.stack([x[index], y[index], np.full(len(index), start)], axis=1) @ view.axes + view.centre
        hits = self._rays.hits(at, np.broadcast_to(-view.axes[2], at.shape))
        hit = np.flatnonzero(hits.faces >= 0)
        index, faces, distances = index[hit], hits.faces[hit], hits.distances[hit]
        second, third = hits.second[hit].astype(np.float32), hits.third[hit].astype(np.float32)
        barycentric = np.stack([1.0 - second - third, second, third], axis=1)
        corners = np.ascontiguousarray(self._faces.take(faces, axis=0).T)
        outside = (self._flat @ view.axes[2] > 0)[faces]
        n = _mixed(self._normals @ view.axes.T.astype(np.float32), corners, barycentric)
        n /= np.maximum(np.sqrt(np.einsum("mi,mi->m", n, n)), np.float32(1e-12))[:, None]
        n[~outside] *= -1.0
        base = _mixed(self._colours, corners, barycentric)
        if paint is not None:
            places = at[hit] - distances[:, None] * view.axes[2]
            base = paint(base, places, n @ view.axes, np.stack([x[index], y[index]], axis=1) / pixel, pixel)
        base[~outside] = INSIDE
        colour[index, :3] = to_srgb(to_light(base) * _light(n)[:, None])
        colour[index, 3] = 1.0
        depth[index] = start - distances
        normal[index] = n
        return colour, depth, normal


def _mixed(values: Reals, corners: Integers, barycentric: Reals) -> Reals:
    """(M, D): of (V, D) values those of (3, M) corners, with (M, 3) weights."""
    first, second, third = (
        values.take(corner, axis=0) * weight[:, None] for corner, weight in zip(corners, barycentric.T, strict=True)
    )
    return np.asarray(first + second + third)


def diverging_colours(values_mm: Array, limit_mm: float = 5.0) -> Array:
    """(M, 3) colours of signed distances, the same as on the page (web/src/fit/distances/distances.ts).

    One pale colour within NOISE_MM, where the scanner's own error explains a distance; a step there, as it is a limit;
    then even steps of lightness and hue (in OKLab, Ottosson 2020) to blue at -limit and beyond, to orange at +limit.
    Blue and orange stay apart for people who do not tell red from green.  NaN is mid-grey.
    """
    values = np.asarray(values_mm, dtype=np.float64)
    known = np.where(np.isnan(values), 0.0, values)
    share = np.clip((np.abs(known) - NOISE_MM) / (limit_mm - NOISE_MM), 0.0, 1.0)
    strength = np.where(np.abs(known) <= NOISE_MM, 0.0, FIRST_STEP + (1.0 - FIRST_STEP) * share)[..., None]
    end = np.where((known < 0.0)[..., None], _INSIDE, _OUTSIDE)
    lab = _MIDDLE + strength * (end - _MIDDLE)
    return np.where(np.isnan(values)[..., None], 0.55, np.clip(_from_oklab(lab), 0.0, 1.0))


# OKLab: blue, near white, orange
_INSIDE, _MIDDLE, _OUTSIDE = np.array([[0.47, -0.035, -0.155], [0.93, 0.002, 0.008], [0.55, 0.105, 0.115]])
_LMS = np.array(
    [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
)
_LAB = np.array(
    [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
)


def _from_oklab(lab: Array) -> Array:
    return np.asarray(to_srgb((lab @ np.linalg.inv(_LAB).T) ** 3 @ np.linalg.inv(_LMS).T), dtype=np.float64)


def _light(normals: Reals) -> Reals:
    """(M,) light reaching surfaces with unit normals in the viewer's axes; 1 is full."""
    total = AMBIENT * (1.0 + 0.35 * normals[:, 1])  # a little more from the sky than from the floor
    for direction, strength in LIGHTS:
        unit = (np.asarray(direction) / np.linalg.norm(direction)).astype(normals.dtype)
        wrapped = np.clip((normals @ unit + 0.15) / 1.15, 0.0, None)  # soft: reaches a little around the corner
        total = total + strength * wrapped
    return np.asarray(total)


def _edges(depth: Array, normal: Array) -> Booleans:
    """(H, W) pixels at outlines and creases."""
    mask = np.zeros(depth.shape, dtype=np.bool_)
    with np.errstate(invalid="ignore"):
        for axis in (0, 1):
            a: tuple[slice, ...] = (slice(None, -1), slice(None)) if axis == 0 else (slice(None), slice(None, -1))
            b: tuple[slice, ...] = (slice(1, None), slice(None)) if axis == 0 else (slice(None), slice(1, None))
            differ = np.abs(depth[a] - depth[b]) > EDGE_DEPTH
            differ |= (np.einsum("hwi,hwi->hw", normal[a], normal[b]) < EDGE_TURN) & np.isfinite(depth[a])
            mask[a] |= differ
            mask[b] |= differ
    return mask


def _draw(colour: Array, depth: Array, line: Line, view: Camera, size: tuple[int, int]) -> None:
    """Lays the visible parts of a line over the picture, in place."""
    width, height = size
    pixel = view.height / height
    points = np.atleast_2d(np.asarray(line.points, dtype=np.float64))
    if line.closed:
        points = np.concatenate([points, points[:1]])
    seen = (points - view.centre) @ view.axes.T
    seen[:, 0] = seen[:, 0] / pixel + width / 2
    seen[:, 1] = height / 2 - seen[:, 1] / pixel
    if len(seen) > 1:  # a point at least every half pixel
        steps = np.ceil(2.0 * np.linalg.norm(np.diff(seen[:, :2], axis=0), axis=1)).astype(int) + 1
        parts = [
            seen[k] + np.linspace(0, 1, n, endpoint=False)[:, None] * (seen[k + 1] - seen[k])
            for k, n in enumerate(steps)
        ]
        seen = np.concatenate([*parts, seen[-1:]])
    column, row = np.floor(seen[:, 0]).astype(int), np.floor(seen[:, 1]).astype(int)
    shown = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    surface = depth[np.clip(row, 0, height - 1) * width + np.clip(column, 0, width - 1)]
    shown &= seen[:, 2] > surface - LINE_TOLERANCE
    if not shown.any():
        return
    scale, margin = LINE_OVERSAMPLING, int(np.ceil(0.5 * line.width)) + 2
    # Only the part of the picture that the line crosses is drawn and mixed: a line covers little of it.
    left, top = max(int(column[shown].min()) - margin, 0), max(int(row[shown].min()) - margin, 0)
    right, bottom = min(int(column[shown].max()) + 1 + margin, width), min(int(row[shown].max()) + 1 + margin, height)
    mask = Image.new("L", ((right - left) * scale, (bottom - top) * scale))
    pen = ImageDraw.Draw(mask)
    radius = 0.5 * line.width * scale
    for px, py in scale * seen[shown, :2] - (scale * left, scale * top):
        pen.ellipse((px - radius, py - radius, px + radius, py + radius), fill=255)
    reduced = mask.resize((right - left, bottom - top), Image.Resampling.BOX)
    cover = (np.asarray(reduced, dtype=np.float64) / 255.0)[..., None]
    crossed = colour.reshape(height, width, -1)[top:bottom, left:right]
    crossed *= 1.0 - cover
    crossed += cover * np.array([*line.colour, 1.0])
