"""How much of the body two stances of one patient have in common: all of it exactly, or all of it nearly.

ONE_BODY gives both stances the same bone scales and body shapes.  ALIKE gives each its own, and the soft shapes too,
held together by springs on their differences d: ½ Σ (d/σ)²; skin and muscle that lying down flattens and spreads
can then differ a little.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.fitting.shared_body import SharedBody, TwoStances
from breastrig.least_squares.newton import System
from breastrig.rig.model import Rig
from breastrig.rig.parameters import BONE_DOFS, RigParameters


@dataclass(frozen=True)
class Coupling:
    """exact: one body; otherwise the expected differences between the stances (inf: apart)."""

    exact: bool
    scale: float = np.inf  # of a bone's scale
    body: float = np.inf  # of a body shape's weight, in the shape's own sigmas
    soft: float = np.inf  # of a soft shape's weight, in the shape's own sigmas; gravity shapes are never held


ONE_BODY = Coupling(exact=True)
ALIKE = Coupling(exact=False, scale=0.1, body=1.0, soft=0.5)  # best of the table in pair.py


class Springs:
    """The energy of the differences, for the layout of both stances."""

    def __init__(self, rig: Rig, coupling: Coupling, layout: SharedBody) -> None:
        sigma = {"body": coupling.body, "soft": coupling.soft, "gravity": np.inf}
        scales = np.zeros((len(rig.bones), BONE_DOFS))
        scales[:, 6:9] = coupling.scale**-2
        shapes = np.array([(sigma[shape.kind] * shape.sigma) ** -2 for shape in rig.shapes])
        self._stiffness = np.concatenate([scales.ravel(), shapes])  # (P,)
        self._second = layout.second

    def energy(self, point: TwoStances) -> float:
        return 0.5 * float(self._stiffness @ self._difference(point) ** 2)

    def added_to(self, system: System, point: TwoStances) -> System:
        """The quadratic model with the springs' own."""
        first, second, k = np.arange(len(self._second)), self._second, self._stiffness
        hessian, gradient = system.hessian.copy(), system.gradient.copy()
        pull = k * self._difference(point)
        gradient[first] += pull
        gradient[second] -= pull
        hessian[first, first] += k
        hessian[second, second] += k
        hessian[first, second] -= k
        hessian[second, first] -= k
        return System(
            hessian,
            gradient,
            system.constraint_jacobian,
            system.constraint,
            system.compliance,
            system.energy + self.energy(point),
        )

    def _difference(self, point: TwoStances) -> Array:
        """(P,) of the additive entries; 0 for the pose."""
        return _additive(point.first) - _additive(point.second)


def _additive(x: RigParameters) -> Array:
    blocks = np.zeros((len(x.scales), BONE_DOFS))
    blocks[:, 6:9] = x.scales
    return np.concatenate([blocks.ravel(), x.weights])
