"""No fold in the skin: one-sided, so that skin which is only pressed together a little costs nothing.

Shapes are made one at a time, and two of them together can push the skin of both sides over the midline or one part of
an armpit over the other.  An edge e of the template, changed by the shapes to e', is stretched along itself by

    s = e'·e / |e|² = 1 + Σ_k α_k (b_jk − b_ik)·e / |e|²,    r = √(A / ℓ²) max(0, s_min − s) / σ

which is linear in the weights; below zero it points the other way, and the triangles beside it are turned over.  A is a
third of the area of these triangles, so that a finer model weighs the same; ℓ is one centimetre.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from breastrig.core.arrays import Array
from breastrig.least_squares.problem import Linearisation, NormalEquations, StructuredTerm
from breastrig.rig.blocks import shape_block
from breastrig.rig.model import Rig
from breastrig.rig.state import BodyState

UNIT_LENGTH = 0.01  # m


@dataclass(frozen=True, eq=False)
class Edges:
    """The E edges of a template that its shapes, each within its range, can press below some stretch."""

    slopes: Array  # (E, S) change of the stretch along the edge for weight 1
    areas: Array  # (E,) m², a third of the triangles beside it


@lru_cache(maxsize=16)
def pressed_edges(rig: Rig, least: float) -> Edges:
    """The edges whose stretch can get below `least`."""
    sides = np.concatenate([rig.faces[:, [0, 1]], rig.faces[:, [1, 2]], rig.faces[:, [2, 0]]])
    corners = rig.template[rig.faces]
    areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    edges, number = np.unique(sides.min(axis=1) * len(rig.template) + sides.max(axis=1), return_inverse=True)
    area = np.bincount(number, np.tile(areas / 3.0, 3))
    first, second = np.divmod(edges, len(rig.template))
    along = rig.template[second] - rig.template[first]
    along /= np.maximum(np.einsum("ei,ei->e", along, along), 1e-12)[:, None]
    moved = rig.shapes_by_vertex[second]
    moved -= rig.shapes_by_vertex[first]
    slopes = np.matmul(along[:, None, :], moved)[:, 0]
    ranges = np.array([[shape.min, shape.max] for shape in rig.shapes]).reshape(-1, 2)
    lowest = 1.0 + np.minimum(slopes * ranges[:, 0], slopes * ranges[:, 1]).sum(axis=1)
    within = lowest < least
    return Edges(slopes[within], area[within])


@dataclass(frozen=True, eq=False)
class Folding(StructuredTerm[BodyState]):
    rig: Rig
    least: float  # stretch of an edge along itself, below which it costs
    sigma: float  # of that stretch, how softly the limit is met
    name: str = "folding"

    @cached_property
    def _edges(self) -> Edges:
        return pressed_edges(self.rig, self.least)

    @cached_property
    def _weights(self) -> Array:
        """(E,)"""
        return np.asarray(np.sqrt(self._edges.areas) / (UNIT_LENGTH * self.sigma))

    def residual(self, state: BodyState) -> Array:
        """(E,)"""
        return self._weights * np.maximum(self.least - 1.0 - self._edges.slopes @ state.x.weights, 0.0)

    def linearise(self, state: BodyState) -> Linearisation:
        """(E,), (E, P)"""
        residual = self.residual(state)
        jacobian = np.zeros((len(residual), state.dof))
        beyond = residual > 0.0
        jacobian[beyond, shape_block(self.rig)] = -(self._weights[:, None] * self._edges.slopes)[beyond]
        return Linearisation(residual, jacobian)

    def normal_equations(self, state: BodyState) -> NormalEquations:
        """JᵀJ, Jᵀr, ½ |r|² from the few edges with a residual."""
        residual = self.residual(state)
        beyond = np.flatnonzero(residual)
        rows = -self._weights[beyond, None] * self._edges.slopes[beyond]
        shapes = shape_block(self.rig)
        hessian, gradient = np.zeros((state.dof, state.dof)), np.zeros(state.dof)
        hessian[shapes, shapes], gradient[shapes] = rows.T @ rows, residual[beyond] @ rows
        return NormalEquations(hessian, gradient, 0.5 * float(residual @ residual))
