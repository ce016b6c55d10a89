"""A lying back rests on the table: nobody sees it, but the table under it is seen.

For each group g of back vertices, with the table's unit normal n, its height level and an expected mean height h_g of
the group above it,

    d_g = n · mean_{v in g} M_v(x) − level − h_g,    r_0 = mean_g(d_g) / σ,    r_g = (d_g − mean_g(d_g)) / σ_s

for how high the whole back lies (cushions, soft tissue) and for its profile, of which bodies differ less; and for
every vertex of the groups  r_v = min(0, n · M_v(x) − level) / σ_f:  nothing reaches through the table.
One residual a group, because the heights of one back are one observation, however many vertices show it.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.plane import Plane
from breastrig.least_squares.problem import Linearisation, NormalEquations, StructuredTerm
from breastrig.rig.model import Rig
from breastrig.rig.state import BodyState


@dataclass(frozen=True, eq=False)
class TableContact(StructuredTerm[BodyState]):
    rig: Rig
    table: Plane
    groups: tuple[Integers, ...]  # vertices of the back
    heights: Array  # (G,) m, expected
    sigma: float  # m, of the whole back
    profile_sigma: float  # m, of a group against the whole
    floor_sigma: float  # m
    name: str = "table_contact"

    @cached_property
    def _vertices(self) -> Integers:
        """(N,) of all groups."""
        return np.concatenate([np.zeros(0, dtype=np.int64), *self.groups])

    @cached_property
    def _means(self) -> Array:
        """(G, N) takes the mean of each group's vertices."""
        means, first = np.zeros((len(self.groups), len(self._vertices))), 0
        for row, group in zip(means, self.groups, strict=True):
            row[first : first + len(group)] = 1.0 / len(group)
            first += len(group)
        return means

    @cached_property
    def _mixed(self) -> Array:
        """(1 + G, G) the mean of the groups, and each against it, in their sigmas."""
        count = len(self.groups)
        mean = np.full((1, count), 1.0 / max(count, 1))
        return np.concatenate([mean / self.sigma, (np.eye(count) - mean) / self.profile_sigma])

    def _above(self, state: BodyState) -> Array:
        """(N,) m of each vertex above the table."""
        return np.asarray(state.vertices[self._vertices] @ self.table.normal - self.table.height)

    def residual(self, state: BodyState) -> Array:
        """(1 + G + N,)"""
        above = self._above(state)
        resting = self._mixed @ (self._means @ above - self.heights)
        return np.concatenate([resting, np.minimum(above, 0.0) / self.floor_sigma])

    def linearise(self, state: BodyState) -> Linearisation:
        """(1 + G + N,), (1 + G + N, P)"""
        rows = self._rows(state)
        below = np.where(self._above(state) < 0.0, 1.0 / self.floor_sigma, 0.0)
        jacobian = np.concatenate([self._mixed @ (self._means @ rows), below[:, None] * rows])
        return Linearisation(self.residual(state), jacobian)

    def normal_equations(self, state: BodyState) -> NormalEquations:
        """JᵀJ, Jᵀr, ½ |r|² without the rows of vertices above the table, nearly all, which are zero."""
        rows, above, count = self._rows(state), self._above(state), 1 + len(self.groups)
        through = np.flatnonzero(above < 0.0)
        residual, jacobian = np.zeros(count + len(through)), np.zeros((count + len(through), rows.shape[1]))
        residual[:count] = self._mixed @ (self._means @ above - self.heights)
        residual[count:] = above[through] / self.floor_sigma
        jacobian[:count] = self._mixed @ (self._means @ rows)
        jacobian[count:] = rows[through] / self.floor_sigma
        return NormalEquations(jacobian.T @ jacobian, residual @ jacobian, 0.5 * float(residual @ residual))

    def _rows(self, state: BodyState) -> Array:
        """(N, P) of the heights above the table."""
        return state.posed.rows(self._vertices, np.tile(self.table.normal, (len(self._vertices), 1)))
