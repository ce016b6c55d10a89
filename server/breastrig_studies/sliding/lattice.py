"""Equilibrium of soft tissue in a lattice of cubes in which skin and chest wall lie embedded.

Cells are filled as far as tissue fills them. Tissue is a stable neo-Hookean (Smith, de Goes and Kim, ACM Transactions
on Graphics 37, 2018, 12) whose change of volume counts once a cell, the skin a net of springs that only pull and
stiffen, the chest wall springs: stiff along its normal, loose along it. Minimised by L-BFGS, preconditioned by the
stiffness without load.
"""

from collections import deque
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csc_matrix, csr_array, diags_array, kron
from scipy.sparse.linalg import SuperLU, splu
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BreastRigError

CORNERS = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)], dtype=np.float64)
GAUSS = 0.5 + (CORNERS - 0.5) / np.sqrt(3.0)
MEMORY, MOST = 20, 300  # of L-BFGS, and its steps
TOLERANCE = 2e-4  # m, largest step of the last two
BEYOND = 0.6  # of a cell, how far a point may lie outside the nearest one
DENSITY = 1000.0  # kg/m³
FULL = 0.3  # share: a cell that is emptier is as stiff as one filled so far


class NotAtRest(BreastRigError):
    """The tissue does not come to rest under this load."""


@dataclass(frozen=True, eq=False)
class Springs:
    """What holds M points (rows of `at`) of the lattice: a wall, with N/m of each."""

    at: csr_array  # (M, N)
    normals: Array  # (M, 3)
    normal: Array  # (M,)
    along: Array  # (M,)
    slip: float  # m along the wall at which it is twice as stiff


@dataclass(frozen=True, eq=False)
class Net:
    """The skin: P points (rows of `at`) and E springs between them."""

    at: csr_array  # (P, N)
    edges: Integers  # (E, 2)
    stiffness: float  # N/m
    taut: float  # times longer than at rest, without loads
    stiffens: float  # stretch at which it is twice as stiff


@dataclass(frozen=True, eq=False)
class Lattice:
    """N nodes and C cells without stress at `nodes`."""

    nodes: Array  # (N, 3) m
    cells: Integers  # (C, 8), in the order of CORNERS
    fill: Array  # (C,) share
    shear: Array  # (C,) Pa
    bulk: float  # times the shear modulus: λ
    held: Booleans  # (N,)
    wall: Springs
    skin: Net

    @cached_property
    def _slopes(self) -> tuple[Array, Array, Array, Array]:
        """(C, 8, 8, 3) 1/m at the Gauss points and (C, 8, 3) in the middle; (C, 8) and (C,) m³ of tissue there."""
        at = self.nodes[self.cells]
        found, sizes = [], []
        for point in (*GAUSS, np.full(3, 0.5)):
            local = _local_slopes(point)  # (8, 3)
            jacobian = np.einsum("cai,aj->cij", at, local)
            found.append(np.einsum("aj,cji->cai", local, np.linalg.inv(jacobian)))
            sizes.append(np.linalg.det(jacobian) * np.maximum(self.fill, FULL))
        if np.min(sizes) <= 0.0:
            raise NotAtRest("A cell of the lattice is inverted.")
        return np.stack(found[:-1], axis=1), found[-1], np.stack(sizes[:-1], axis=1) / len(GAUSS), sizes[-1]

    @cached_property
    def mass(self) -> Array:
        """(N,) kg."""
        share = np.repeat(DENSITY / 8.0 * self._slopes[3] * self.fill / np.maximum(self.fill, FULL), 8)
        return np.asarray(np.bincount(self.cells.ravel(), share, len(self.nodes)), dtype=np.float64)

    @cached_property
    def _lengths(self) -> Array:
        """(E,) m of the skin's springs at rest."""
        ends = (self.skin.at @ self.nodes)[self.skin.edges]
        return np.asarray(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / self.skin.taut)

    def energy(self, displacement: Array, gravity: Array, posed: Array) -> tuple[float, Array]:
        """(J, (N, 3) N its gradient) at (N, 3) m under (3,) m/s²; `posed` (M, 3) m: where the wall's points go."""
        slopes, middle, sizes, size = self._slopes
        at = displacement[self.cells].swapaxes(1, 2)  # (C, 3, 8)
        turned = np.eye(3) + np.einsum("cia,cgaj->cgij", at, slopes, optimize=True)
        cofactors, volumes = _cofactors(turned)
        weights = self.shear[:, None] * sizes
        stored = float((weights * (0.5 * ((turned**2).sum(axis=(2, 3)) - 3.0) - (volumes - 1.0))).sum())
        stress = weights[..., None, None] * (turned - cofactors)
        force = np.einsum("cgij,cgaj->cai", stress, slopes, optimize=True)
        whole, grown = _cofactors(np.eye(3) + at @ middle)
        lame = self.bulk * self.shear * size
        stored += float(0.5 * (lame * (grown - 1.0) ** 2).sum())
        force += np.einsum("c,cij,caj->cai", lame * (grown - 1.0), whole, middle, optimize=True)
        gradient: Array = np.stack(
            [np.bincount(self.cells.ravel(), force[..., k].ravel(), len(self.nodes)) for k in range(3)], axis=1
        )
        gradient -= self.mass[:, None] * gravity
        stored -= float(self.mass @ displacement @ gravity)
        for energy, pull in (self._of_wall(displacement, posed), self._of_skin(displacement)):
            stored += energy
            gradient += pull
        return stored, gradient

    def _of_wall(self, displacement: Array, posed: Array) -> tuple[float, Array]:
        wall = self.wall
        off = wall.at @ displacement - posed
        across = np.einsum("mi,mi->m", off, wall.normals)
        along = off - across[:, None] * wall.normals
        square = (along**2).sum(axis=1) / wall.slip**2
        energy = 0.5 * (wall.normal * across**2 + wall.along * wall.slip**2 * square * (1.0 + 0.5 * square)).sum()
        pull = (wall.normal * across)[:, None] * wall.normals + (wall.along * (1.0 + square))[:, None] * along
        return float(energy), np.asarray(wall.at.T @ pull)

    def _of_skin(self, displacement: Array) -> tuple[float, Array]:
        skin, rest = self.skin, self._lengths
        ends = (skin.at @ (self.nodes + displacement))[skin.edges]
        ways = ends[:, 1] - ends[:, 0]
        lengths = np.linalg.norm(ways, axis=1)
        strain = np.maximum(lengths / rest - 1.0, 0.0)
        square = (strain / skin.stiffens) ** 2
        energy = 0.5 * skin.stiffness * (rest**2 * strain**2 * (1.0 + 0.5 * square)).sum()
        pull = (skin.stiffness * rest * strain * (1.0 + square) / lengths)[:, None] * ways
        count = skin.at.shape[0]
        both = np.stack(
            [
                np.bincount(skin.edges[:, 1], pull[:, k], count) - np.bincount(skin.edges[:, 0], pull[:, k], count)
                for k in range(3)
            ],
            axis=1,
        )
        return float(energy), np.asarray(skin.at.T @ both)

    @cached_property
    def _factor(self) -> tuple[Integers, SuperLU]:
        """The free entries and the factorised stiffness without load."""
        slopes, middle, sizes, size = self._slopes
        weights = self.shear[:, None] * sizes
        plain = np.einsum("cg,cgai,cgbi->cab", weights, slopes, slopes, optimize=True)
        blocks = np.einsum("cab,ij->caibj", plain, np.eye(3)) + np.einsum(
            "cg,cgaj,cgbi->caibj", weights, slopes, slopes, optimize=True
        )
        blocks += np.einsum("c,cai,cbj->caibj", self.bulk * self.shear * size, middle, middle, optimize=True)
        entries = (3 * self.cells[:, :, None] + np.arange(3)).reshape(len(self.cells), 24)
        rows, columns = np.repeat(entries, 24, axis=1), np.tile(entries, (1, 24))
        count = self.nodes.size
        matrix = coo_array((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(count, count)).tocsr()
        wall, skin = self.wall, self.skin
        square = np.einsum("m,mi,mj->mij", wall.normal - wall.along, wall.normals, wall.normals)
        square += wall.along[:, None, None] * np.eye(3)
        points = np.arange(len(square))[:, None, None]
        i, j = np.arange(3)[:, None], np.arange(3)[None]
        of_wall = coo_array(
            (
                square.ravel(),
                (
                    np.broadcast_to(3 * points + i, square.shape).ravel(),
                    np.broadcast_to(3 * points + j, square.shape).ravel(),
                ),
            ),
            shape=(square.shape[0] * 3,) * 2,
        ).tocsr()
        wide = kron(wall.at, np.eye(3), "csr")
        matrix = matrix + wide.T @ of_wall @ wide
        edges = np.arange(len(skin.edges))
        ends = coo_array(
            (np.repeat([1.0, -1.0], len(edges)), (np.tile(edges, 2), skin.edges.T.ravel())),
            shape=(len(edges), skin.at.shape[0]),
        ).tocsr()
        matrix = matrix + kron(skin.stiffness / 3.0 * (ends @ skin.at).T @ (ends @ skin.at), np.eye(3), "csr")
        free = np.flatnonzero(np.repeat(~self.held, 3))
        inner = csc_matrix(matrix[free][:, free] + diags_array(np.full(len(free), 1e-6)))
        options = {"SymmetricMode": True}
        return free, splu(inner, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)

    def at_rest(self, gravity: Array, posed: Array, start: Array) -> Array:
        """(N, 3) m: the displacement under (3,) m/s² of gravity; held nodes stay at `start` (N, 3) m. NotAtRest."""
        free, factor = self._factor
        flat = start.ravel().copy()

        def at(values: Array) -> tuple[float, Array]:
            energy, gradient = self.energy(values.reshape(-1, 3), gravity, posed)
            return energy, gradient.ravel()[free]

        energy, gradient = at(flat)
        kept: deque[tuple[Array, Array, float]] = deque(maxlen=MEMORY)
        small = 0
        for _ in range(MOST):
            way = _way(gradient, kept, factor)
            slope, length = float(way @ gradient), 1.0
            if slope >= 0.0:
                kept.clear()
                way = -factor.solve(gradient)
                slope = float(way @ gradient)
            length = min(1.0, 0.02 / float(np.abs(way).max()))  # m, a step at most
            while True:
                tried = flat.copy()
                tried[free] += length * way
                reached, there = at(tried)
                if reached <= energy + 1e-4 * length * slope + 1e-12:
                    break
                length *= 0.4
                if length < 1e-6:
                    raise NotAtRest("The search for the tissue's rest goes no further down.")
            step, change = length * way, there - gradient
            if (product := float(step @ change)) > 0.0:
                kept.append((step, change, 1.0 / product))
            flat, energy, gradient = tried, reached, there
            small = small + 1 if np.abs(step).max() < TOLERANCE else 0
            if small == 2:
                return flat.reshape(-1, 3)
        raise NotAtRest(f"The tissue does not come to rest in {MOST} steps: it is too soft.")


def _way(gradient: Array, kept: deque[tuple[Array, Array, float]], factor: SuperLU) -> Array:
    """The direction of L-BFGS (Nocedal and Wright, Numerical Optimization, 2006, algorithm 7.4)."""
    left, shares = gradient.copy(), []
    for step, change, weight in reversed(kept):
        shares.append(weight * float(step @ left))
        left -= shares[-1] * change
    way = factor.solve(left)
    for (step, change, weight), share in zip(kept, reversed(shares), strict=True):
        way += (share - weight * float(change @ way)) * step
    return np.asarray(-way)


def _local_slopes(point: Array) -> Array:
    """(8, 3) of the trilinear functions of a unit cube."""
    values = np.where(CORNERS > 0.5, point, 1.0 - point)
    signs = np.where(CORNERS > 0.5, 1.0, -1.0)
    return np.stack([signs[:, k] * values[:, (k + 1) % 3] * values[:, (k + 2) % 3] for k in range(3)], axis=1)


def _cofactors(matrices: Array) -> tuple[Array, Array]:
    """(..., 3, 3) the derivatives of the determinants, (...) the determinants."""
    rows = [matrices[..., k, :] for k in range(3)]
    found = np.stack([np.cross(rows[1], rows[2]), np.cross(rows[2], rows[0]), np.cross(rows[0], rows[1])], axis=-2)
    return found, np.asarray(np.einsum("...i,...i->...", rows[0], found[..., 0, :]))


def embedded(points: Array, low: Array, step: float, cells: Integers, numbers: Integers) -> csr_array:
    """(M, N) trilinear weights of (M, 3) m points in the nearest cells: (C, 3) `cells` of `numbers` (C, 8) nodes."""
    local = (points - low) / step
    nearest = cKDTree(cells + 0.5).query(local, p=np.inf)[1]
    inside = np.clip(local - cells[nearest], -BEYOND, 1.0 + BEYOND)
    weights = np.prod(np.where(CORNERS > 0.5, inside[:, None], 1.0 - inside[:, None]), axis=2)
    rows = np.repeat(np.arange(len(points)), 8)
    shape = (len(points), int(numbers.max()) + 1)
    return coo_array((weights.ravel(), (rows, numbers[nearest].ravel())), shape).tocsr()
