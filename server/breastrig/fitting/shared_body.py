"""The unknowns of one patient in two stances: one vector in which the body stands once.

    [ first stance's P entries, the body among them | second stance's entries without the body ]

The body is what lying down does not change: the bones' scales and the shapes of kind "body".  Pose and the
shapes of kind "soft" and "gravity" belong to each stance.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.least_squares.newton import System
from breastrig.least_squares.quadratic_program import Bounds
from breastrig.rig.model import Rig
from breastrig.rig.parameters import BONE_DOFS, RigParameters


@dataclass(frozen=True, eq=False)
class SharedBody:
    """Which of a stance's P entries are the body's, and where the second stance's entries stand."""

    rig: Rig
    exact: bool = True  # False: nothing stands once, each stance has a body of its own

    @cached_property
    def body_shapes(self) -> Booleans:
        """(S,)"""
        return np.array([shape.kind == "body" for shape in self.rig.shapes], dtype=np.bool_)

    @cached_property
    def shared(self) -> Booleans:
        """(P,)"""
        bones = len(self.rig.bones)
        blocks = np.zeros((bones, BONE_DOFS), dtype=np.bool_)
        blocks[:, 6:9] = True
        return np.concatenate([blocks.ravel(), self.body_shapes]) & self.exact

    @cached_property
    def second(self) -> Integers:
        """(P,) place of each of the second stance's entries in the vector of both."""
        places = np.arange(len(self.shared))
        own = np.flatnonzero(~self.shared)
        places[own] = len(self.shared) + np.arange(len(own))
        return places

    @property
    def size(self) -> int:
        """N, the length of the vector of both."""
        return len(self.shared) + int((~self.shared).sum())

    def added(self, first: Array, second: Array) -> Array:
        """(N,) of two (P,): the body's entries are added up."""
        result = np.zeros(self.size)
        result[: len(first)] = first
        result[self.second] += second
        return result

    def system(self, first: System, second: System) -> System:
        """Both stances' Gauss-Newton models as one; each keeps its own constraints."""
        size, own = self.size, len(self.shared)
        hessian = np.zeros((size, size))
        hessian[:own, :own] = first.hessian
        hessian[np.ix_(self.second, self.second)] += second.hessian
        constraints = len(first.constraint)
        jacobian = np.zeros((constraints + len(second.constraint), size))
        jacobian[:constraints, :own] = first.constraint_jacobian
        jacobian[constraints:, self.second] = second.constraint_jacobian
        return System(
            hessian,
            self.added(first.gradient, second.gradient),
            jacobian,
            np.concatenate([first.constraint, second.constraint]),
            np.concatenate([first.compliance, second.compliance]),
            first.energy + second.energy,
        )

    def bounds(self, first: Bounds, second: Bounds) -> Bounds:
        """What both stances allow."""
        size, own = self.size, len(self.shared)
        lower, upper = np.full(size, -np.inf), np.full(size, np.inf)
        lower[:own], upper[:own] = first.lower, first.upper
        lower[self.second] = np.maximum(lower[self.second], second.lower)
        upper[self.second] = np.minimum(upper[self.second], second.upper)
        rows, limits = [], []
        for one, places in ((first, np.arange(own)), (second, self.second)):
            if one.rows is not None and one.row_limits is not None:
                row = np.zeros((len(one.rows), size))
                row[:, places] = one.rows
                rows.append(row)
                limits.append(one.row_limits)
        return Bounds(lower, upper, np.concatenate(rows), np.concatenate(limits)) if rows else Bounds(lower, upper)

    def free(self, own: Booleans) -> Booleans:
        """(N,) of the (P,) entries that a stage lets move in either stance."""
        result = np.zeros(self.size, dtype=np.bool_)
        result[: len(own)] = own
        result[self.second] = own
        return result

    def agreed(self, first: RigParameters, second: RigParameters) -> "TwoStances":
        """Two stances with their mean body; as they are when each has its own."""
        if not self.exact:
            return TwoStances(first, second, self)
        scales, weights = 0.5 * (first.scales + second.scales), 0.5 * (first.weights + second.weights)

        def with_body(x: RigParameters) -> RigParameters:
            return replace(x, scales=scales, weights=np.where(self.body_shapes, weights, x.weights))

        return TwoStances(with_body(first), with_body(second), self)


@dataclass(frozen=True, eq=False)
class TwoStances:
    """A point on the manifold of both stances; the body's values are the same to the last bit."""

    first: RigParameters
    second: RigParameters
    layout: SharedBody

    @property
    def dof(self) -> int:
        return self.layout.size

    def retract(self, step: Array) -> "TwoStances":
        """The point reached along the (N,) tangent `step`."""
        return TwoStances(
            self.first.retract(step[: self.first.dof]), self.second.retract(step[self.layout.second]), self.layout
        )
