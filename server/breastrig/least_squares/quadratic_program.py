"""The convex quadratic program of one step, solved to rounding.

    minimise ½ dᵀH d + gᵀd    with    lower <= d <= upper,    A d <= a,    C d = c

Unknowns that neither a bound nor a row holds (rotations and translations of the bones, when all joints give) are
eliminated by Cholesky first; what is left (82 of 136) goes to daqp, a dual active-set method (Arnström, Bemporad and
Axehill, A dual active-set solver for embedded quadratic programming using recursive LDLᵀ updates, 2022), which
takes up and releases bounds until the conditions of Karush, Kuhn and Tucker hold, after finitely many exchanges.
All of it takes 0.35 ms; daqp alone, without the elimination, 0.7 ms.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import daqp
import numpy as np
from numpy.linalg import LinAlgError
from scipy.linalg import lapack

from breastrig.core.arrays import Array


def cholesky(matrix: Array) -> Array:
    """The lower factor L of a symmetric positive definite (N, N) matrix L Lᵀ; LinAlgError for any other.

    What stands above the diagonal is neither read nor cleared.
    """
    if not len(matrix):
        return matrix
    factor, info = lapack.dpotrf(matrix, lower=1, clean=0)
    if info:
        raise LinAlgError("The matrix is not positive definite.")
    return np.asarray(factor)


def solve_lower(factor: Array, right: Array, transposed: bool = False) -> Array:
    """L⁻¹ right or L⁻ᵀ right, for (N, N) L of which the lower half is read, and (N,) or (N, M) right."""
    if not len(factor):
        return right
    return np.asarray(lapack.dtrtrs(factor, right, lower=1, trans=int(transposed))[0])


TOLERANCE = 1e-11  # of a bound or row, where the Hessian's diagonal is scaled to 1: far above rounding, far below 1e-9
INEQUALITY, EQUALITY = 0, 5  # daqp's kinds of rows
SOLVED = 1  # daqp's answer


@dataclass(frozen=True, eq=False)
class Bounds:
    """Where a step may go: a box around 0, and rows A with limits a."""

    lower: Array  # (P,) <= 0, -inf where free
    upper: Array  # (P,) >= 0
    rows: Array | None = None  # (R, P)
    row_limits: Array | None = None  # (R,) >= 0, rows @ step <= row_limits


def joined_bounds(parts: Sequence[Bounds]) -> Bounds:
    """Of steps that follow one another."""
    rows, limits, first, size = [], [], 0, sum(len(part.lower) for part in parts)
    for part in parts:
        if part.rows is not None and part.row_limits is not None:
            row = np.zeros((len(part.rows), size))
            row[:, first : first + len(part.lower)] = part.rows
            rows.append(row)
            limits.append(part.row_limits)
        first += len(part.lower)
    box = (np.concatenate([getattr(part, side) for part in parts]) for side in ("lower", "upper"))
    return Bounds(*box, *((np.concatenate(rows), np.concatenate(limits)) if rows else ()))


def _dual_active_set(hessian: Array, gradient: Array, rows: Array, lower: Array, upper: Array, equal: int) -> Array:
    """(N + R,) minimiser, then the multipliers of the rows; the last `equal` rows are equations.

    lower and upper (N + R,) hold the unknowns' bounds, then the rows'.
    """
    count = len(gradient)
    if not count:
        return gradient
    scale = 1.0 / np.sqrt(np.diag(hessian))  # unknowns in standard deviations and rows of length 1 ...
    rows = np.ascontiguousarray(rows * scale)
    lengths = np.linalg.norm(rows, axis=1)
    lengths[lengths == 0.0] = 1.0
    scales = np.concatenate([scale, lengths])  # ... so that one tolerance fits all
    kinds = np.full(len(scales), INEQUALITY, dtype=np.int32)
    kinds[len(scales) - equal :] = EQUALITY
    solution, _, answer, about = daqp.solve(
        hessian * scale * scale[:, None],
        gradient * scale,
        rows / lengths[:, None],
        upper / scales,
        lower / scales,
        kinds,
        primal_tol=TOLERANCE,
        dual_tol=TOLERANCE,
    )
    if answer != SOLVED:
        raise LinAlgError(f"The quadratic program has no solution (daqp answers {answer}).")
    return np.concatenate([solution * scale, about["lam"][count:] / lengths])


def minimiser(hessian: Array, gradient: Array, bounds: Bounds, equations: Array, right: Array) -> tuple[Array, Array]:
    """((P,) the step d, (E,) the multipliers λ of its equations C d = c: H d + g + Cᵀλ + ... = 0).

    hessian: (P, P) symmetric; gradient: (P,); equations C: (E, P); right c: (E,).
    Raises LinAlgError when the Hessian is not positive definite, or when bounds and rows contradict each other.
    """
    equal, rows, limits = len(equations), equations, right
    if bounds.rows is not None and bounds.row_limits is not None:
        rows, limits = np.concatenate([bounds.rows, equations]), np.concatenate([bounds.row_limits, right])
    floors = np.full(len(limits), -np.inf)
    floors[len(limits) - equal :] = right
    held = np.isfinite(bounds.lower) | np.isfinite(bounds.upper) | rows.any(axis=0)
    inside, outside = np.flatnonzero(held), np.flatnonzero(~held)
    lower, upper = bounds.lower[inside], bounds.upper[inside]
    order, first = np.concatenate([outside, inside]), len(outside)
    ordered, pull = hessian.take(order, axis=0).take(order, axis=1), gradient[order]
    factor = cholesky(ordered[:first, :first])
    mixed = solve_lower(factor, np.column_stack([ordered[:first, first:], pull[:first]]))
    found = _dual_active_set(
        ordered[first:, first:] - mixed[:, :-1].T @ mixed[:, :-1],
        pull[first:] - mixed[:, :-1].T @ mixed[:, -1],
        rows[:, inside],
        np.concatenate([lower, floors]),
        np.concatenate([upper, limits]),
        equal,
    )
    step = np.zeros(len(gradient))
    step[inside] = np.clip(found[: len(inside)], lower, upper)  # off by rounding only
    step[outside] = -solve_lower(factor, mixed[:, -1] + mixed[:, :-1] @ step[inside], transposed=True)
    return step, found[len(found) - equal :]
