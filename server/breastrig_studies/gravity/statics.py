"""Equilibrium of a soft body under gravity: Newton's method with a line search on the energy, load step by load step.

Linear tetrahedra: where tissue hardly changes its volume they are a little too stiff, far less than a
patient's stiffness is unknown, for a fraction of the work of quadratic ones (docs/decisions/0020).  SciPy's SuperLU
solves the systems.
"""

from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BreastRigError
from breastrig.geometry.normals import face_crosses
from breastrig.volume.tetrahedra import shape_gradients
from breastrig_studies.gravity.materials import Law, Membrane, NeoHookean

TOLERANCE = 1e-4  # m, of the last Newton step; what is left is its square
STEPS, HALVINGS = 24, 8  # of Newton and of its line search
WHOLE = 2  # tries along a step that may not go down
LOADS = 4  # steps in which stress is built up
ROUNDS, RETURNED = 20, 2e-4  # of putting nodes back under the whole load, and m: from where on they do not move
SMALLEST_LOAD = 1.0 / 8.0  # share of the load below which a step is given up


class NoEquilibrium(BreastRigError):
    """The body does not come to rest under this load: too soft for its size."""


@dataclass(frozen=True, eq=False)
class Tissue:
    """The mechanical properties of a body."""

    shear: Array  # (T,) Pa of each tetrahedron
    skin: float  # N/m: shear modulus of skin times its thickness
    incompressibility: float = 15.0  # λ/μ: a Poisson's ratio of 0.47
    density: float = 1000.0  # kg/m³
    stretch: float = 1.0  # of the skin on the body without loads: living skin is taut


@dataclass(frozen=True, eq=False)
class _Part:
    """One law on its E elements of C corners each: volume or skin."""

    law: Law
    corners: Integers  # (E, C) nodes
    slopes: Array  # (E, C, 3) 1/m, gradients of the shape functions
    sizes: Array  # (E, 1) m³ or m², in the body's shape
    before: Array  # (E, 1, 3, 3) deformation gradient in that shape

    @cached_property
    def dofs(self) -> Integers:
        """(E, 3 C)."""
        return (3 * self.corners[:, :, None] + np.arange(3)).reshape(len(self.corners), -1)

    @cached_property
    def operator(self) -> Array:
        """(E, 1, 9, 3 C): from an element's displacements to the change of its deformation gradient."""
        made = np.zeros((len(self.corners), 1, 3, 3, self.corners.shape[1], 3))
        for axis in range(3):
            made[:, 0, axis, :, :, axis] = (self.slopes @ self.before[:, 0]).swapaxes(1, 2)
        return made.reshape(len(self.corners), 1, 9, -1)

    @cached_property
    def weights(self) -> Array:
        """(E, 1) m³ or m² without stress."""
        return np.asarray(self.sizes / self.law.growth(self.before))

    def gradients(self, displacement: Array) -> Array:
        found = np.einsum("eqij,ej->eqi", self.operator, displacement[self.dofs], optimize=True)
        return np.asarray(found.reshape(self.before.shape) + self.before)


class SoftBody:
    """A tetrahedral body; displacements are (N, 3) m at its nodes."""

    def __init__(self, points: Array, tetrahedra: Integers, skin: Integers, held: Booleans, tissue: Tissue) -> None:
        """Without stress at (N, 3) m; `tetrahedra` (T, 4), `skin` (S, 3) triangles, `held` (N,) points that stay.

        NoEquilibrium where a tetrahedron is inverted.
        """
        self.points = points
        self.free = ~held  # (N,)
        self._free = np.repeat(self.free, 3)
        slopes, volumes = shape_gradients(points, tetrahedra)
        if volumes.min() <= 0.0:
            raise NoEquilibrium("A tetrahedron of this body is inverted, so that it cannot rest.")
        law = NeoHookean(tissue.shear, tissue.incompressibility * tissue.shear)
        self._parts = [_part(law, tetrahedra, slopes, volumes)]
        if len(skin) and tissue.skin > 0.0:
            crosses = face_crosses(points, skin)
            twice = np.linalg.norm(crosses, axis=1, keepdims=True)
            edges = points[skin[:, [2, 0, 1]]] - points[skin[:, [1, 2, 0]]]  # opposite of each corner
            slopes = np.cross(crosses[:, None], edges) / (twice**2)[:, :, None]
            tangents = tissue.stretch * _tangents(crosses / twice)[:, None]
            membrane = Membrane(np.full(len(skin), tissue.skin), tangents)
            self._parts.append(_part(membrane, skin, slopes, 0.5 * twice[:, 0]))
        quarters = np.repeat(0.25 * tissue.density * volumes, 4)
        self._mass = np.bincount(tetrahedra.ravel(), quarters, len(points))

    @cached_property
    def _pattern(self) -> tuple[Integers, Integers, csc_matrix]:
        """(free entries, their places in the matrix's data, the matrix's structure) of all parts' (E, 3 C, 3 C)."""
        number = np.full(len(self._free), -1)
        number[self._free] = np.arange(self._free.sum())
        sizes = [part.dofs.shape[1] for part in self._parts]
        parts = list(zip(self._parts, sizes, strict=True))
        rows = np.concatenate([np.repeat(number[part.dofs], size, axis=1).ravel() for part, size in parts])
        columns = np.concatenate([np.tile(number[part.dofs], (1, size)).ravel() for part, size in parts])
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

    def _linearised(self, displacement: Array, gravity: Array, definite: bool = False) -> tuple[Array, csc_matrix]:
        """(forces, stiffness), `definite`: of each element without the ways in which it gives by itself."""
        flat, residual, blocks = displacement.ravel(), -(self._mass[:, None] * gravity).ravel(), []
        for part in self._parts:
            _, stress, stiffness = part.law.response(part.gradients(flat))
            if definite:
                sizes, ways = np.linalg.eigh(stiffness)
                stiffness = (ways * np.maximum(sizes, 0.0)[..., None, :]) @ ways.swapaxes(-1, -2)
            force = np.einsum("eqij,eqi->ej", part.operator, stress * part.weights[..., None], optimize=True)
            residual += np.bincount(part.dofs.ravel(), force.ravel(), len(flat))
            points = part.operator.swapaxes(-1, -2) @ (stiffness * part.weights[..., None, None]) @ part.operator
            blocks.append(points.sum(axis=1).ravel())
        used, places, structure = self._pattern
        matrix = structure.copy()
        matrix.data = np.bincount(places, np.concatenate(blocks)[used], len(structure.data))
        return residual, matrix

    def at_rest(self, gravity: Array, start: Array | None = None, before: Array | None = None) -> Array:
        """(N, 3) m: the displacement at which the body rests under (3,) m/s² gravity, from `start`, where it rests
        under the gravity `before`.

        From one to the other it goes in steps that halve where Newton's method fails.  Raises NoEquilibrium.
        """
        displacement = np.zeros_like(self.points) if start is None else start
        before = np.zeros(3) if before is None else before
        load, share = 0.0, 1.0
        while load < 1.0:
            tried = min(load + share, 1.0)
            found = self._newton(displacement, before + tried * (gravity - before))
            if found is not None:
                displacement, load = found, tried
            elif share > SMALLEST_LOAD:
                share *= 0.5
            else:
                raise NoEquilibrium(f"The body does not come to rest under {load:.0%} of its weight: it is too soft.")
        return displacement

    def resting(self, gravity: Array) -> "SoftBody":
        """The body in the same shape, so stressed that it rests in it under (3,) m/s² gravity.

        Its nodes are put back wherever they go, and how tissue was deformed on the way is kept (Gee, Förster and Wall,
        International Journal for Numerical Methods in Biomedical Engineering 26, 2010, 52).  Raises NoEquilibrium.
        """
        body, before = self, np.zeros(3)
        for k in range(1, LOADS + ROUNDS):
            load = min(k / LOADS, 1.0) * gravity
            moved = body.at_rest(load, None, before)
            body, before = copy(body), load
            body._parts = [replace(part, before=part.gradients(moved.ravel())) for part in body._parts]
            if k >= LOADS and np.abs(moved).max() < RETURNED:
                return body
        raise NoEquilibrium("The body does not come to rest in this shape: it is too soft.")

    def _newton(self, displacement: Array, gravity: Array) -> Array | None:
        energy = self.energy(displacement, gravity)
        if not np.isfinite(energy):
            return None
        for _ in range(STEPS):
            for definite in (False, True):
                found = self._step(displacement, energy, gravity, definite)
                if found is not None:
                    break
            else:
                return None
            displacement, energy, size = found
            if size < TOLERANCE and not definite:
                return displacement
        return None

    def _step(
        self, displacement: Array, energy: float, gravity: Array, definite: bool
    ) -> tuple[Array, float, float] | None:
        """(displacement, its energy, m of the step) after one step of Newton's method; None where it does not go down.

        Where tissue is about to buckle only a `definite` stiffness does (Teran, Sifakis, Irving and Fedkiw, SCA 2005).
        """
        residual, matrix = self._linearised(displacement, gravity, definite)
        flat: Array = np.zeros(len(residual))
        flat[self._free] = -_solved(matrix, residual[self._free])
        slope, step = float(residual @ flat), np.asarray(flat.reshape(-1, 3))
        largest = float(np.abs(step).max())
        for length in 0.5 ** np.arange(HALVINGS if definite else WHOLE):
            tried = displacement + length * step
            reached = self.energy(tried, gravity)
            lower = slope <= 0.0 and reached <= energy + 1e-4 * length * slope
            if lower or (largest < TOLERANCE and np.isfinite(reached)):
                return tried, reached, float(length * largest)
        return None


def _solved(matrix: csc_matrix, right: Array) -> Array:
    factor = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return np.asarray(factor.solve(right))


def _part(law: Law, corners: Integers, slopes: Array, sizes: Array) -> _Part:
    return _Part(law, corners, slopes, sizes[:, None], np.tile(np.eye(3), (len(corners), 1, 1, 1)))


def _tangents(normals: Array) -> Array:
    """(..., 3, 2) orthonormal directions across (..., 3) unit normals."""
    helper = np.where(np.abs(normals[..., :1]) < 0.7, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    first = np.cross(normals, helper)
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    return np.stack([first, np.cross(normals, first)], axis=-1)
