"""The quadratic program of one step: against all active sets where they can be tried, else by its conditions."""

from itertools import product

import numpy as np
import pytest
import scipy.linalg as sla

from breastrig.least_squares.quadratic_program import Bounds, minimiser

LOWER, FREE, UPPER = -1, 0, 1


def hessian_of(rng: np.random.Generator, size: int, decades: float = 1.0) -> np.ndarray:
    """A positive definite matrix whose unknowns differ in size by some decades."""
    root = rng.normal(size=(size + 3, size)) * 10.0 ** rng.uniform(-decades, decades, size)
    return root.T @ root


def box(rng: np.random.Generator, size: int) -> Bounds:
    """Room around 0: none on a side for many, as when the last step ended at a bound; some unknowns without bounds."""
    lower, upper = -rng.uniform(0.0, 0.3, size), rng.uniform(0.0, 0.3, size)
    lower[rng.random(size) < 0.3] = 0.0
    upper[rng.random(size) < 0.3] = 0.0
    lower[rng.random(size) < 0.3] = -np.inf
    upper[rng.random(size) < 0.3] = np.inf
    return Bounds(lower, upper)


def best_of_all_active_sets(h, g, bounds) -> np.ndarray:
    """The minimiser, found by trying every unknown free, at its lower and at its upper bound."""
    size, best, least = len(g), None, np.inf
    for chosen in product((LOWER, FREE, UPPER), repeat=size):
        state = np.array(chosen)
        step = np.where(state == LOWER, bounds.lower, np.where(state == UPPER, bounds.upper, 0.0))
        if not np.isfinite(step).all():
            continue
        free = np.flatnonzero(state == FREE)
        step[free] = np.linalg.solve(h[np.ix_(free, free)], -(g + h @ step)[free])
        inside = (step >= bounds.lower - 1e-12).all() and (step <= bounds.upper + 1e-12).all()
        energy = 0.5 * step @ h @ step + g @ step
        if inside and energy < least:
            best, least = step, energy
    assert best is not None
    return best


def kkt_residual(h, g, bounds, step) -> float:
    """How far the conditions of Karush, Kuhn and Tucker are from being met, in standard deviations.

    A step along the negative slope must end where it began when it is cut at the bounds.
    """
    size = 1.0 / np.sqrt(np.diag(h))
    slope = (h @ step + g) * size
    stays = np.clip(step / size - slope, bounds.lower / size, bounds.upper / size) - step / size
    return float(np.abs(stays).max())


@pytest.mark.parametrize("seed", range(12))
def test_no_active_set_is_better(seed: int) -> None:
    rng = np.random.default_rng(seed)
    size = 5
    h, g, bounds = hessian_of(rng, size), 3.0 * rng.normal(size=size), box(rng, size)
    np.testing.assert_allclose(minimiser(h, g, bounds), best_of_all_active_sets(h, g, bounds), atol=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_a_program_of_a_fits_size_meets_its_conditions(seed: int) -> None:
    rng = np.random.default_rng(seed)
    size = 136
    h, g, bounds = hessian_of(rng, size, 2.0), 30.0 * rng.normal(size=size), box(rng, size)
    step = minimiser(h, g, bounds)
    assert kkt_residual(h, g, bounds, step) < 1e-9
    assert (step >= bounds.lower).all()  # to the last bit
    assert (step <= bounds.upper).all()
    at_bound = (step == bounds.lower) | (step == bounds.upper)
    assert at_bound.sum() > 10  # the bounds matter


def test_without_bounds_it_is_one_linear_system(rng: np.random.Generator) -> None:
    h, g = hessian_of(rng, 7), rng.normal(size=7)
    free = Bounds(np.full(7, -np.inf), np.full(7, np.inf))
    np.testing.assert_allclose(h @ minimiser(h, g, free), -g, atol=1e-9)


def test_the_given_arrays_stay_as_they_are(rng: np.random.Generator) -> None:
    h, g, bounds = hessian_of(rng, 8), rng.normal(size=8), box(rng, 8)
    given = [h, g, bounds.lower, bounds.upper]
    copies = [array.copy() for array in given]
    minimiser(h, g, bounds)
    for array, copy in zip(given, copies, strict=True):
        np.testing.assert_array_equal(array, copy)


def test_a_matrix_that_is_not_positive_definite_is_refused() -> None:
    free = Bounds(np.full(2, -np.inf), np.full(2, np.inf))
    with pytest.raises(sla.LinAlgError, match="not positive definite"):
        minimiser(np.diag([1.0, -1.0]), np.ones(2), free)


def test_bounds_that_contradict_each_other_are_refused() -> None:
    with pytest.raises(sla.LinAlgError, match="no solution"):
        minimiser(np.eye(2), np.zeros(2), Bounds(np.ones(2), np.zeros(2)))
