"""A cloud of points -> triangles: thinned out, with normals towards the sensor, and a surface through them.

The surface never lies more than REACH from a point, so no skin is made up that nobody has seen: a gap of 15 mm stays
open.
"""

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadScan
from breastrig.geometry.fields.implicit_surface import implicit_surface
from breastrig.geometry.normals import point_normals
from breastrig.scan.piece import Piece, PointCloud
from breastrig.scan.units import STRAY

FROM_POINTS = "The file holds points alone; the surface was made from them, and gaps of 15 mm or more stay open."
REACH = 0.007  # m from the nearest point, at most: so a gap of 15 mm is never bridged
SPREAD = 0.007  # m between neighbours, at most: wider spread points say nothing of the skin between them
LEAST_CELL, MOST_CELL = 0.003, 0.005  # m, edge of the grid: the triangles of a fused depth scan are 3 to 5 mm long
CELLS = 40_000_000  # of the grid: 200 MB
THINNED = 0.0025  # m: of denser points one mean stands for each cube; it is what a depth camera resolves at 1 m
WIDTH = 1.5  # of the Gaussian, in spacings: less follows the noise, more flattens a nipple
KEYS = 2**20  # cubes along an axis: three such numbers fit into one
LEAST_POINTS = 500
ALONE = 3  # points in a cube of three times REACH: fewer are strays
FAR = 0.3  # m beyond the box that the unit is decided by


def surface_from_points(cloud: PointCloud, metres: float) -> Piece:
    """The triangles, in the cloud's unit of `metres`.  BadScan when there are too few points, or too far apart."""
    points = cloud.points * metres
    kept = _together(points)
    bytes_of_colour = None if cloud.colours is None else cloud.colours.astype(np.float64)
    points, normals, colours = _thinned(points[kept], _some(cloud.normals, kept), _some(bytes_of_colour, kept))
    if len(points) < LEAST_POINTS:
        raise BadScan(f"This scan has only {len(points):,} points in one place; export it as a triangle mesh.")
    tree = cKDTree(points)
    distances = np.asarray(tree.query(points, k=5)[0])[:, 1:]
    spacing = float(np.median(distances))
    if spacing > SPREAD:
        raise BadScan(
            f"The points of this scan are {1e3 * spacing:.0f} mm apart, too far to lay a skin through them; "
            "export it as a triangle mesh."
        )
    dense = np.median(distances, axis=1) < REACH
    points, normals, colours = points[dense], _some(normals, dense), _some(colours, dense)
    if normals is None or not (np.linalg.norm(normals, axis=1) > 0.1).mean() > 0.99:
        normals = point_normals(points, None if cloud.sensor is None else cloud.sensor * metres)
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    volume = float(np.prod(np.ptp(points, axis=0) + 4.0 * REACH))
    cell = max(float(np.clip(spacing, LEAST_CELL, MOST_CELL)), (volume / CELLS) ** (1.0 / 3.0))
    vertices, faces = implicit_surface(points, normals, WIDTH * max(spacing, LEAST_CELL), cell, REACH)
    painted = None if colours is None or not len(vertices) else _painted(vertices, points, colours)
    return Piece(vertices / metres, faces, painted)


def _some(values: Array | None, kept: Booleans) -> Array | None:
    return None if values is None else values[kept]


def _together(points: Array) -> Booleans:
    """(N,) which points are no strays (far from all others, or nearly alone)."""
    low, high = np.quantile(points, [STRAY, 1.0 - STRAY], axis=0)
    kept = ((points > low - FAR) & (points < high + FAR)).all(axis=1)
    whose, count = _grouped(np.floor((points[kept] - low) / (3.0 * REACH)).astype(np.int64))
    kept[kept] = count[whose] >= ALONE
    return np.asarray(kept)


def _thinned(points: Array, normals: Array | None, colours: Array | None) -> tuple[Array, Array | None, Array | None]:
    """The cloud with the mean of the points in each cube of side THINNED."""
    if not len(points):
        return points, normals, colours
    cube = np.floor((points - points.min(axis=0)) / THINNED).astype(np.int64)
    whose, count = _grouped(cube)

    def mean(values: Array | None) -> Array | None:
        if values is None:
            return None
        return np.stack([np.bincount(whose, column) for column in values.T.astype(np.float64)], axis=1) / count[:, None]

    places = mean(points)
    assert places is not None
    return places, mean(normals), mean(colours)


def _grouped(cube: Integers) -> tuple[Integers, Integers]:
    """(N,) the group of each of the (N, 3) cubes, equal ones together, and the size of each group."""
    if not len(cube):
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    keys = cube - cube.min(axis=0)  # of a few metres by millimetres: far below KEYS
    flat = (keys[:, 0] * KEYS + keys[:, 1]) * KEYS + keys[:, 2]
    _, whose, count = np.unique(flat, return_inverse=True, return_counts=True)
    return whose.ravel(), count


def _painted(vertices: Array, points: Array, colours: Array) -> np.typing.NDArray[np.uint8]:
    """(V, 3) of the four nearest points, the nearer the more."""
    distances, who = cKDTree(points).query(vertices, k=4)
    weights = 1.0 / np.maximum(distances, 1e-6)
    mixed = np.einsum("vk,vki->vi", weights, colours[who]) / weights.sum(axis=1, keepdims=True)
    return np.asarray(np.round(mixed).astype(np.uint8))
