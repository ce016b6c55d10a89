"""Equilibrium of a soft body under gravity: Newton's method with a line search on the energy, load step by load step.

Quadratic tetrahedra (displacement of second degree on straight elements) do not lock where the tissue hardly changes
its volume; elements and quadrature come from scikit-fem (BSD-3), the systems are solved by SciPy's SuperLU.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix
from scipy.sparse.linalg import splu
from skfem import Basis, ElementTetP2, FacetBasis, MeshTet

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BreastRigError
from breastrig.volume.gravity.materials import Law, Membrane, NeoHookean

TOLERANCE = 1e-4  # m, of the last Newton step; what is left is its square
STEPS, HALVINGS = 16, 8  # of Newton and of its line search
ROUNDS, RETURNED = 20, 3e-5  # of the fixed point, and m: how near it comes to the loaded shape
SMALLEST_LOAD = 1.0 / 8.0  # share of the load below which a step is given up


class NoEquilibrium(BreastRigError):
    """The body does not come to rest under this load: too soft for its size."""


@dataclass(frozen=True, eq=False)
class Tissue:
    """What a body is made of."""

    shear: Array  # (T,) Pa of each tetrahedron
    skin: float  # N/m: shear modulus of skin times its thickness
    incompressibility: float = 15.0  # λ/μ: a Poisson's ratio of 0.47
    density: float = 1000.0  # kg/m³
    stretch: float = 1.0  # of the skin on the body without loads: living skin is taut


@dataclass(frozen=True, eq=False)
class _Part:
    """Quadrature points of one law: volume or skin."""

    law: Law
    operator: Array  # (E, Q, 9, 30): from an element's displacements to the displacement gradient
    weights: Array  # (E, Q) m³ or m²
    dofs: Integers  # (E, 30)

    def gradients(self, displacement: Array) -> Array:
        found = np.einsum("eqij,ej->eqi", self.operator, displacement[self.dofs], optimize=True)
        return np.asarray(found.reshape(*found.shape[:2], 3, 3) + np.eye(3))


class SoftBody:
    """A tetrahedral body at rest without loads; displacements are (N, 3) m at its quadratic nodes."""

    def __init__(self, points: Array, tetrahedra: Integers, skin: Integers, held: Booleans, tissue: Tissue) -> None:
        """`points` (P, 3) m, `tetrahedra` (T, 4), `skin` (S, 3) its triangles, `held` (P,) points that stay."""
        self.mesh = MeshTet(np.ascontiguousarray(points.T), np.ascontiguousarray(tetrahedra.T))
        basis = Basis(self.mesh, ElementTetP2(), intorder=2)
        self.nodes = np.asarray(basis.doflocs.T)  # (N, 3) m, corners first
        self.free = ~self._held_nodes(basis, held)  # (N,) nodes
        self._free = np.repeat(self.free, 3)
        order = _matching(self.mesh.t.T, tetrahedra)
        shear = tissue.shear[order]
        self._parts = [_part(basis, NeoHookean(shear, tissue.incompressibility * shear))]
        if len(skin) and tissue.skin > 0.0:
            edge = FacetBasis(self.mesh, ElementTetP2(), facets=_facets(self.mesh, skin), intorder=2)
            normals = np.moveaxis(np.asarray(edge.normals), 0, -1)
            stiffness = np.full(len(normals), tissue.skin)
            self._parts.append(_part(edge, Membrane(stiffness, tissue.stretch * _tangents(normals))))
        mass = np.zeros(basis.N)
        for k, shape in enumerate(basis.basis):
            np.add.at(mass, basis.element_dofs[k], (np.asarray(shape[0]) * basis.dx).sum(axis=1))
        self._mass = tissue.density * mass

    def on_surface(self, triangles: Integers, barycentric: Array) -> csr_matrix:
        """(M, N) from displacements of nodes to (M, 3) `barycentric` places in (M, 3) triangles of points."""
        edges = np.sort(np.asarray(self.mesh.edges.T), axis=1)
        names = {(int(a), int(b)): len(self.mesh.p.T) + k for k, (a, b) in enumerate(edges)}
        rows, columns, values = [], [], []
        for k in range(3):
            i, j = triangles[:, k], triangles[:, (k + 1) % 3]
            a, b = barycentric[:, k], barycentric[:, (k + 1) % 3]
            middle = [names[tuple(sorted(pair))] for pair in zip(i.tolist(), j.tolist(), strict=True)]
            rows += [np.arange(len(i))] * 2
            columns += [i, np.array(middle)]
            values += [a * (2.0 * a - 1.0), 4.0 * a * b]
        shape = len(triangles), len(self.nodes)
        return csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape)

    def between(self, values: Array) -> Array:
        """(N, 3) at the nodes: (P, 3) values of the points, and their means on the edges."""
        return np.concatenate([values, values[np.asarray(self.mesh.edges)].mean(axis=0)])

    @staticmethod
    def _held_nodes(basis: Basis, held: Booleans) -> Booleans:
        nodes = np.zeros(basis.N, dtype=np.bool_)
        nodes[basis.nodal_dofs[0]] = held
        nodes[basis.edge_dofs[0]] = held[basis.mesh.edges].all(axis=0)
        return nodes

    @cached_property
    def _pattern(self) -> tuple[Integers, Integers, csc_matrix]:
        """(free entries, their places in the matrix's data, the matrix's structure) of all parts' (E, 30, 30)."""
        number = np.full(len(self._free), -1)
        number[self._free] = np.arange(self._free.sum())
        rows = np.concatenate([np.repeat(number[part.dofs], 30, axis=1).ravel() for part in self._parts])
        columns = np.concatenate([np.tile(number[part.dofs], (1, 30)).ravel() for part in self._parts])
        used = np.flatnonzero((rows >= 0) & (columns >= 0))
        size = int(self._free.sum())
        keys, places = np.unique(columns[used] * size + rows[used], return_inverse=True)
        starts = np.searchsorted(keys // size, np.arange(size + 1))
        return used, places, csc_matrix((np.zeros(len(keys)), keys % size, starts), (size, size))

    def energy(self, displacement: Array, gravity: Array) -> float:
        """J, of a (N, 3) m displacement under (3,) m/s² gravity; inf when an element is inverted."""
        flat = displacement.ravel()
        stored = sum(float((part.law.energy(part.gradients(flat)) * part.weights).sum()) for part in self._parts)
        return stored - float(self._mass @ displacement @ gravity)

    def forces(self, displacement: Array, gravity: Array) -> Array:
        """(N, 3) N: the gradient of the energy; reactions at held nodes."""
        return self._linearised(displacement, gravity)[0].reshape(-1, 3)

    def stiffness(self, displacement: Array) -> csc_matrix:
        """(3 F, 3 F) N/m: the Hessian of the energy by the F free nodes."""
        return self._linearised(displacement, np.zeros(3))[1]

    def _linearised(self, displacement: Array, gravity: Array) -> tuple[Array, csc_matrix]:
        flat, residual, blocks = displacement.ravel(), -(self._mass[:, None] * gravity).ravel(), []
        for part in self._parts:
            _, stress, stiffness = part.law.response(part.gradients(flat))
            force = np.einsum("eqij,eqi->ej", part.operator, stress * part.weights[..., None], optimize=True)
            residual += np.bincount(part.dofs.ravel(), force.ravel(), len(flat))
            points = part.operator.swapaxes(-1, -2) @ (stiffness * part.weights[..., None, None]) @ part.operator
            blocks.append(points.sum(axis=1).ravel())
        used, places, structure = self._pattern
        matrix = structure.copy()
        matrix.data = np.bincount(places, np.concatenate(blocks)[used], len(structure.data))
        return residual, matrix

    def at_rest(self, gravity: Array, start: Array | None = None) -> Array:
        """(N, 3) m: the displacement at which the body rests under (3,) m/s² gravity, from the initial point `start`.

        Gravity is put on in steps that halve where Newton's method fails.  Raises NoEquilibrium.
        """
        displacement = np.zeros_like(self.nodes) if start is None else start
        load, share = (0.0, 0.5) if start is None else (0.0, 1.0)
        while load < 1.0:
            tried = min(load + share, 1.0)
            # From a start that is at rest under other loads, all of the new load is put on at once where that works.
            found = self._newton(displacement, gravity * tried)
            if found is not None:
                displacement, load, share = found, tried, min(2.0 * share, 1.0)
            elif share > SMALLEST_LOAD and (start is None or load > 0.0):
                share *= 0.5
            elif start is not None:
                return self.at_rest(gravity)
            else:
                raise NoEquilibrium(f"The body does not come to rest under {load:.0%} of its weight: it is too soft.")
        return displacement

    def _newton(self, displacement: Array, gravity: Array) -> Array | None:
        energy = self.energy(displacement, gravity)
        for _ in range(STEPS):
            residual, matrix = self._linearised(displacement, gravity)
            step: Array = np.zeros(len(residual))
            step[self._free] = -_solved(matrix, residual[self._free])
            slope = float(residual @ step)
            if slope > 0.0:  # not a minimum along the step: go down
                step, slope = -step, -slope
            step = np.asarray(step.reshape(-1, 3))
            for k in range(HALVINGS):
                length = 0.5**k
                tried = displacement + length * step
                reached = self.energy(tried, gravity)
                if reached <= energy + 1e-4 * length * slope or (
                    np.abs(step).max() < TOLERANCE and np.isfinite(reached)
                ):
                    break
            else:
                return None
            displacement, energy = tried, reached
            if length * np.abs(step).max() < TOLERANCE:
                return displacement
        return None


def unloaded(
    loaded: Array, body_at: Callable[[Array], SoftBody], gravity: Array, near: float = RETURNED
) -> tuple[SoftBody, Array]:
    """(the body without loads, its (N, 3) m displacement at rest) whose points rest at (P, 3) m `loaded`,
    `near` m from it in root mean square.

    `body_at` makes a body of (P, 3) points.  Fixed point: what the body misses is added to its unloaded points
    (Sellier, Journal of Fluids and Structures 27, 2011, 1461).  Raises NoEquilibrium where that does not converge.
    """
    points, least = loaded, np.inf
    for _ in range(ROUNDS):
        body = body_at(points)
        displacement = body.at_rest(gravity)
        missed = loaded - points - displacement[: len(points)]
        distance = float(np.sqrt((missed**2).sum(axis=1).mean()))
        if distance < near:
            return body, displacement
        if distance > least:
            break
        least, points = distance, points + missed
    raise NoEquilibrium(
        f"No shape without gravity sinks into this one (missed by {1e3 * least:.1f} mm in the mean): it is too soft."
    )


def _solved(matrix: csc_matrix, right: Array) -> Array:
    factor = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return np.asarray(factor.solve(right))


def _part(basis: Basis | FacetBasis, law: Law) -> _Part:
    slopes = np.stack([np.asarray(shape[0].grad) for shape in basis.basis])  # (10, 3, E, Q)
    operator = np.zeros((*slopes.shape[2:], 3, 3, len(slopes), 3))
    for axis in range(3):
        operator[:, :, axis, :, :, axis] = np.moveaxis(slopes, (0, 1), (3, 2))
    dofs = (3 * np.asarray(basis.element_dofs).T[:, :, None] + np.arange(3)).reshape(slopes.shape[2], -1)
    return _Part(law, operator.reshape(*slopes.shape[2:], 9, -1), np.asarray(basis.dx), dofs)


def _matching(found: Integers, given: Integers) -> Integers:
    """(T,) which of the given tetrahedra each of the mesh's is."""
    order = np.lexsort(np.sort(given, axis=1).T)
    place = np.zeros(len(given), dtype=np.int64)
    place[np.lexsort(np.sort(found, axis=1).T)] = order
    return place


def _facets(mesh: MeshTet, triangles: Integers) -> Integers:
    """(S,) the mesh's facets with these corners."""
    known = {tuple(corners): k for k, corners in enumerate(np.sort(mesh.facets.T, axis=1).tolist())}
    return np.array([known[tuple(corners)] for corners in np.sort(triangles, axis=1).tolist()], dtype=np.int64)


def _tangents(normals: Array) -> Array:
    """(..., 3, 2) orthonormal directions across (..., 3) unit normals."""
    helper = np.where(np.abs(normals[..., :1]) < 0.7, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    first = np.cross(normals, helper)
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    return np.stack([first, np.cross(normals, first)], axis=-1)
