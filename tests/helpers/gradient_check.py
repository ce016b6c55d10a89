"""The shared derivative check: central differences along the manifold's own retract."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from breastrig.least_squares.newton import wide
from breastrig.rig.modes import with_modes


def numeric_jacobian(term: Any, x: Any, step: float = 1e-6) -> np.ndarray:
    """(M, P) central differences of term.residual at x."""
    columns = []
    for k in range(x.dof):
        move = np.zeros(x.dof)
        move[k] = step
        columns.append((term.residual(x.retract(move)) - term.residual(x.retract(-move))) / (2 * step))
    return np.stack(columns, axis=1)


def parameter_names(rig: Any) -> Sequence[str]:
    """A name for each tangent entry, so that a failing check says which one is wrong."""
    kinds = [f"{kind}_{axis}" for kind in ("rotation", "translation", "scale") for axis in "xyz"]
    return [f"{bone}.{kind}" for bone in rig.bone_names for kind in kinds] + list(with_modes(rig).shape_names)


def assert_jacobian_matches_finite_differences(term: Any, rig: Any, x: Any, tolerance: float = 2e-7) -> None:
    """The analytic Jacobian equals central differences, and linearise repeats the residual exactly."""
    linearised = term.linearise(x)
    np.testing.assert_array_equal(linearised.residual, term.residual(x))
    expected = numeric_jacobian(term, x)
    size = max(1.0, float(np.abs(expected).max()))
    wrong = np.abs(wide(linearised.jacobian, x.dof) - expected).max(axis=0) > tolerance * size
    names = parameter_names(rig)
    assert not wrong.any(), f"{term.name}: wrong derivative for {[names[k] for k in np.flatnonzero(wrong)]}"
