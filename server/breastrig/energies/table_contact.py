"""A lying back rests on the table: nobody sees it, but the table under it is seen.

For G parts of the back, with the table's unit normal n and its height level,

    r = A (h − μ),  h_g = n · mean_{v in g} M_v(x) − level,  with Aᵀ A = Σ⁻¹,

for how high each part lies, μ and Σ being what is expected of this body (fitting/body/lying_heights.py); and for every
vertex of them  r_v = min(0, n · M_v(x) − level) / σ_f:  nothing reaches through the
table.  One residual a part, because its height is one observation, however many vertices show it.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.scipy_parts import cholesky, solve_lower
from breastrig.geometry.plane import Plane
from breastrig.least_squares.problem import Linearisation, NormalEquations, StructuredTerm
from breastrig.rig.model import Rig
from breastrig.rig.state import BodyState


@dataclass(frozen=True, eq=False)
class TableContact(StructuredTerm[BodyState]):
    rig: Rig
    table: Plane
    parts: tuple[Integers, ...]  # vertices of each part of the back, none of them in two
    mean: Array  # (G,) m, expected
    covariance: Array  # (G, G) m²
    floor_sigma: float  # m
    name: str = "table_contact"

    @cached_property
    def _vertices(self) -> Integers:
        """(N,) of all parts."""
        return np.concatenate([np.zeros(0, dtype=np.int64), *self.parts])

    @cached_property
    def _whitening(self) -> Array:
        """(G, G)"""
        return solve_lower(cholesky(self.covariance), np.eye(len(self.covariance)))

    @cached_property
    def _whitened_means(self) -> Array:
        """(G, N) takes the mean of each part's vertices, and A of it."""
        means, first = np.zeros((len(self.parts), len(self._vertices))), 0
        for row, part in zip(means, self.parts, strict=True):
            row[first : first + len(part)] = 1.0 / len(part)
            first += len(part)
        return np.asarray(self._whitening @ means)

    def _above(self, state: BodyState) -> Array:
        """(N,) m of each vertex above the table."""
        return np.asarray(state.vertices[self._vertices] @ self.table.normal - self.table.height)

    def _resting(self, above: Array) -> Array:
        """(G,)"""
        return np.asarray(self._whitened_means @ above - self._whitening @ self.mean)

    def residual(self, state: BodyState) -> Array:
        """(G + N,)"""
        above = self._above(state)
        return np.concatenate([self._resting(above), np.minimum(above, 0.0) / self.floor_sigma])

    def linearise(self, state: BodyState) -> Linearisation:
        """(G + N,), (G + N, P)"""
        rows = self._rows(state)
        below = np.where(self._above(state) < 0.0, 1.0 / self.floor_sigma, 0.0)
        jacobian = np.concatenate([self._whitened_means @ rows, below[:, None] * rows])
        return Linearisation(self.residual(state), jacobian)

    def normal_equations(self, state: BodyState) -> NormalEquations:
        """Without the rows of vertices above the table, which are zero: nearly all of them."""
        rows, above = self._rows(state), self._above(state)
        through = np.flatnonzero(above < 0.0)
        residual = np.concatenate([self._resting(above), above[through] / self.floor_sigma])
        jacobian = np.concatenate([self._whitened_means @ rows, rows[through] / self.floor_sigma])
        return NormalEquations(jacobian.T @ jacobian, residual @ jacobian, 0.5 * float(residual @ residual))

    def _rows(self, state: BodyState) -> Array:
        """(N, P) of the heights above the table."""
        return state.posed.rows(self._vertices, np.tile(self.table.normal, (len(self._vertices), 1)))
