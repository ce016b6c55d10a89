"""A simulated depth camera: what a cheap sensor would see of a known surface, with its errors.

For virtual patients whose true surface is known.  The errors are those of structured-light and stereo sensors
(Khoshelham and Elberink 2012: noise and step grow with the square of the distance):

* noise per pixel, stronger on grazing surfaces, and a step of quantisation;
* drift: each view is believed to be taken from slightly elsewhere, and its depth is bent by a slow wave;
* no answer on grazing surfaces, at depth edges, beyond the range, and on blind spots (wet, black or shining skin).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_erosion, maximum_filter, minimum_filter

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.normals import face_normals
from breastrig.geometry.rays import RayCaster
from breastrig.geometry.rotations import exp_so3

REFERENCE = 0.5  # m, the distance for which noise and step are given


@dataclass(frozen=True)
class DepthCamera:
    """A sensor; the numbers resemble a tablet's depth camera of the Structure kind at its short range."""

    width: int = 320  # pixels
    height: int = 240
    field_of_view: float = 1.01  # rad, from left to right
    nearest: float = 0.30  # m
    farthest: float = 1.20  # m
    noise: float = 0.0012  # m, standard deviation at REFERENCE, seen straight
    step: float = 0.0006  # m, quantisation at REFERENCE
    wave: float = 0.0008  # m, size of the slow bending of a view
    shift: float = 0.0010  # m, how far a view is believed to be from where it is
    turn: float = 0.0015  # rad, the same for its direction
    grazing: float = 1.26  # rad, no answer where the surface is seen more obliquely
    speckle: float = 0.01  # share of single pixels without answer
    edge: float = 0.015  # m, neighbouring depths further apart are an edge, where there is no answer

    @property
    def focal_length(self) -> float:
        """pixels"""
        return float(0.5 * self.width / np.tan(0.5 * self.field_of_view))


@dataclass(frozen=True, eq=False)
class View:
    """The position and axes of a camera."""

    position: Array  # (3,) m
    axes: Array  # (3, 3), rows: right, down, forward; unit

    def in_camera(self, points: Array) -> Array:
        """(M, 3) m in the camera's axes."""
        return np.asarray((points - self.position) @ self.axes.T)


@dataclass(frozen=True, eq=False)
class DepthImage:
    """The depths of one view, with the position that the sensor assumes for it."""

    camera: DepthCamera
    view: View
    depth: Array  # (height, width) m along the forward axis, NaN without answer

    def points(self) -> Array:
        """(M, 3) m: the answers as points."""
        row, column = np.nonzero(np.isfinite(self.depth))
        along = _rays_of(self.camera)[row, column] * self.depth[row, column, None]
        return np.asarray(along @ self.view.axes + self.view.position)


def look_at(position: Array, target: Array, up: Array) -> View:
    """A view from `position` (m) towards `target` (m) with `up` upwards in the picture."""
    forward = (target - position) / np.linalg.norm(target - position)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    return View(position, np.stack([right, np.cross(forward, right), forward]))


def take(
    vertices: Array,
    faces: Integers,
    views: Sequence[View],
    camera: DepthCamera,
    random: np.random.Generator,
    blind_spots: Array | None = None,
) -> list[DepthImage]:
    """One depth image for each view of the surface (V, 3) m, (F, 3).

    `blind_spots` (M, 4): centre and radius (m) of patches of skin that never answer.
    """
    rays, normals = RayCaster(vertices, faces), face_normals(vertices, faces)
    return [_take(rays, normals, view, camera, random, blind_spots) for view in views]


def _take(
    rays: RayCaster,
    normals: Array,
    view: View,
    camera: DepthCamera,
    random: np.random.Generator,
    blind_spots: Array | None,
) -> DepthImage:
    shape = (camera.height, camera.width)
    along = _rays_of(camera).reshape(-1, 3)
    lengths = np.linalg.norm(along, axis=1)
    directions = along / lengths[:, None] @ view.axes
    origins = np.broadcast_to(view.position, directions.shape)
    hit, distance = rays.first_hits(origins, directions, 2.0 * camera.farthest)
    seen = hit >= 0
    distance = np.where(seen, distance, 0.0)
    depth = distance / lengths
    slant = np.abs(np.einsum("mi,mi->m", normals[hit], directions))  # cosine of the angle of incidence
    seen &= (depth > camera.nearest) & (depth < camera.farthest)
    seen &= slant > np.cos(camera.grazing) * random.uniform(0.8, 1.6, len(slant))  # a ragged, not a sharp limit
    seen &= random.random(len(slant)) > camera.speckle
    if blind_spots is not None:
        at = origins + distance[:, None] * directions
        for x, y, z, radius in blind_spots:
            ragged = radius * random.uniform(0.85, 1.1, len(at))
            near = np.flatnonzero(np.abs(at[:, 0] - x) <= 1.1 * radius)  # the others are farther, without roots
            seen[near] &= np.linalg.norm(at[near] - [x, y, z], axis=1) > ragged[near]
    far = (depth / REFERENCE) ** 2
    depth = depth + camera.noise * far / np.maximum(slant, 0.3) * _grain(shape, random).ravel()
    depth = depth + _wave(camera, random).ravel()
    step = np.maximum(camera.step * far, 1e-9)
    depth = np.round(depth / step) * step
    seen2d = seen.reshape(shape)
    seen2d &= ~_edges(np.where(seen, distance / lengths, 9.0).reshape(shape), camera.edge)
    believed = View(
        view.position + camera.shift * random.standard_normal(3),
        view.axes @ exp_so3(camera.turn * random.standard_normal(3)),
    )
    return DepthImage(camera, believed, np.where(seen2d, depth.reshape(shape), np.nan))


def _rays_of(camera: DepthCamera) -> Array:
    """(height, width, 3) direction of each pixel in the camera's axes, with forward part 1."""
    row, column = np.meshgrid(np.arange(camera.height), np.arange(camera.width), indexing="ij")
    x = (column + 0.5 - camera.width / 2) / camera.focal_length
    y = (row + 0.5 - camera.height / 2) / camera.focal_length
    return np.stack([x, y, np.ones_like(x)], axis=-1)


def _grain(shape: tuple[int, int], random: np.random.Generator) -> Array:
    """Noise of unit size, alike over two or three pixels, as block matching makes it."""
    fine = random.standard_normal(shape)
    mixed = fine + np.roll(fine, 1, 0) + np.roll(fine, 1, 1) + np.roll(fine, (1, 1), (0, 1))
    return np.asarray(mixed / 2.0)


def _wave(camera: DepthCamera, random: np.random.Generator) -> Array:
    """A slow bend of the whole image: a few cosines of up to one and a half periods."""
    row, column = np.meshgrid(np.linspace(0, 1, camera.height), np.linspace(0, 1, camera.width), indexing="ij")
    bend = np.zeros_like(row)
    for _ in range(4):
        down, across = random.uniform(-1.5, 1.5, 2)
        bend += np.cos(2.0 * np.pi * (down * row + across * column) + random.uniform(0.0, 2.0 * np.pi))
    return np.asarray(camera.wave * bend / np.sqrt(2.0))


def _edges(depth: Array, largest_step: float) -> Booleans:
    """(height, width) pixels beside a jump of the depth."""
    spread = maximum_filter(depth, size=3) - minimum_filter(depth, size=3)
    return np.asarray(~binary_erosion(spread < largest_step, border_value=True))
