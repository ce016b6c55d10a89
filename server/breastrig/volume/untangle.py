"""Moves nodes until every tetrahedron is turned the right way round and well shaped.

The energy of Garanzha et al. 2021 ("Foldover-free maps in 50 lines of code"): inverse mean ratios with a regularised
determinant, which stays finite for inverted tetrahedra, minimised by SciPy's L-BFGS while the regularisation shrinks.
Only nodes near bad tetrahedra move, those on stronger springs only where the others alone do not do; springs are in
inverse mean ratios for a move by the tetrahedra's size.
"""

import numpy as np
from scipy.sparse import csr_array

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.volume.volume_mesh import SOUND, scaled_jacobians

WANTED = 1.2 * SOUND  # scaled Jacobian; files have fewer digits
RINGS = 3  # of tetrahedra around a bad one whose nodes move
ROUNDS = 6  # of shrinking the regularisation, each with
STEPS = 60  # iterations at the most
POWER = 3  # of the inverse mean ratios that are summed: the worst count most
ACROSS = 30.0  # times stiffer: surfaces slide along themselves
EPSILON = 0.01  # of the determinant's regularisation, of a regular tetrahedron's
REGULAR = np.linalg.inv(np.array([[1.0, 0.5, 0.5], [0.0, np.sqrt(0.75), np.sqrt(1 / 12)], [0.0, 0.0, np.sqrt(2 / 3)]]))


def untangle(points: Array, tetrahedra: Integers, rest: Array, springs: Array, normals: Array) -> Array:
    """(N, 3) m: the points, moved where tetrahedra are inverted or badly shaped; `rest` (N, 3) m gives their sizes.

    `springs` (N,) hold the nodes: the weaker the earlier they move, inf: never; across surfaces, along their `normals`
    (N, 3), they are stiffer. Returns the best found where some cannot be mended.
    """
    sizes = np.cbrt(np.linalg.det(_edges(rest, tetrahedra))) * 2 ** (1 / 6)  # edges of regular ones
    for strongest in np.unique(springs[np.isfinite(springs)]):
        for _ in range(ROUNDS):
            quality = scaled_jacobians(points, tetrahedra)
            if quality.min() >= WANTED:
                return points
            held = np.where(springs > strongest, np.inf, springs)
            points = _relaxed(points, tetrahedra, sizes, quality < WANTED, held, normals)
    return points


def _edges(points: Array, tetrahedra: Integers) -> Array:
    """(M, 3, 3) m, in columns, from the first corner to the others."""
    corners = points[tetrahedra]
    return np.asarray((corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1))


def _relaxed(points: Array, tetrahedra: Integers, sizes: Array, bad: Booleans, springs: Array, normals: Array) -> Array:
    """One round: the points after minimising the energy around the bad tetrahedra."""
    from scipy.optimize import minimize  # slow to load, and most fits need no tetrahedra

    free = _near(bad, tetrahedra, len(points))
    free = free[np.isfinite(springs[free])]
    near = np.isin(tetrahedra, free).any(axis=1)
    chosen = tetrahedra[near]
    shapes = _Shapes(points, chosen, sizes[near], free, springs[free], normals[free])
    found = minimize(
        shapes.energy, shapes.start.ravel(), jac=True, method="L-BFGS-B", options={"maxiter": STEPS, "maxcor": 10}
    )
    moved = points.copy()
    moved[free] = found.x.reshape(-1, 3) * shapes.unit
    return moved


def _near(bad: Booleans, tetrahedra: Integers, count: int) -> Integers:
    """The nodes of the bad tetrahedra and of RINGS around them, ascending."""
    touched: Booleans = np.zeros(count, dtype=bool)
    for _ in range(RINGS):
        touched[tetrahedra[bad]] = True
        bad = np.asarray(touched[tetrahedra].any(axis=1))
    return np.flatnonzero(touched)


class _Shapes:
    """The energy of some tetrahedra over their free nodes, whose places are in units of the median size."""

    def __init__(
        self, points: Array, tetrahedra: Integers, sizes: Array, free: Integers, springs: Array, normals: Array
    ) -> None:
        self.unit = float(np.median(sizes))
        self.points, self.tetrahedra, self.free, self.springs = points / self.unit, tetrahedra, free, springs[:, None]
        self.normals = normals
        self.regular = REGULAR * (self.unit / sizes)[:, None, None]
        self.start = self.points[free]
        moves = np.flatnonzero(np.isin(tetrahedra, free))
        rows = np.searchsorted(free, tetrahedra.ravel()[moves])
        self.gathered = csr_array((np.ones(len(moves)), (rows, moves)), (len(free), tetrahedra.size))
        lowest = float(np.linalg.det(_edges(self.points, tetrahedra) @ self.regular).min())
        self.epsilon = np.sqrt(EPSILON**2 + 0.25 * min(lowest, 0.0) ** 2)

    def energy(self, unknowns: Array) -> tuple[float, Array]:
        points = self.points.copy()
        points[self.free] = unknowns.reshape(-1, 3)
        jacobians = _edges(points, self.tetrahedra) @ self.regular
        a, b, c = jacobians.transpose(2, 0, 1)  # columns
        cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=2)
        determinants = np.einsum("mi,mi->m", a, cofactors[:, :, 0])
        root = np.hypot(self.epsilon, determinants)
        positive = np.where(
            determinants > 0.0, 0.5 * (determinants + root), 0.5 * self.epsilon**2 / (root - determinants)
        )
        squares = np.einsum("mij,mij->m", jacobians, jacobians)
        shape = squares / (3.0 * positive ** (2 / 3))
        slope = -2.0 / 3.0 * shape / root  # by the determinant: the derivative of `positive` is itself by `root`
        by_jacobian = (2.0 * shape / squares)[:, None, None] * jacobians + slope[:, None, None] * cofactors
        by_jacobian *= POWER * (shape ** (POWER - 1))[:, None, None]
        by_edges = (by_jacobian @ self.regular.transpose(0, 2, 1)).transpose(0, 2, 1)  # rows: corners 1, 2, 3
        by_corners = np.concatenate([-by_edges.sum(axis=1, keepdims=True), by_edges], axis=1)
        away = points[self.free] - self.start
        across = ACROSS * np.einsum("mi,mi->m", away, self.normals)[:, None] * self.normals
        pull = self.springs * (away + across)
        return float((shape**POWER).sum() + (pull * away).sum()), (
            self.gathered @ by_corners.reshape(-1, 3) + 2.0 * pull
        ).ravel()
