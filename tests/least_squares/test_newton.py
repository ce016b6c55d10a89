"""The step of the solver on problems whose answer is known."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from breastrig.least_squares.newton import Status, assemble, damped_step, energy_of
from breastrig.least_squares.problem import Linearisation, inlier_chance, mixture_cost, outlier_cost
from breastrig.least_squares.quadratic_program import Bounds


@dataclass(frozen=True, eq=False)
class Flat:
    """R^n as a manifold."""

    values: np.ndarray

    @property
    def dof(self) -> int:
        return len(self.values)

    def retract(self, step: np.ndarray) -> "Flat":
        return Flat(self.values + step)


@dataclass(frozen=True, eq=False)
class Linear:
    """r = A x − b."""

    matrix: np.ndarray
    right: np.ndarray
    name: str = "linear"

    def residual(self, x: Flat) -> np.ndarray:
        return self.matrix @ x.values - self.right

    def linearise(self, x: Flat) -> Linearisation:
        return Linearisation(self.residual(x), self.matrix)


def term(rng: np.random.Generator, rows: int = 12, columns: int = 6) -> Linear:
    return Linear(rng.normal(size=(rows, columns)), rng.normal(size=rows))


def step(terms, x, lower=-np.inf, upper=np.inf, damping=1e-12, least=None):
    size = x.dof
    bounds = Bounds(np.full(size, lower) - x.values, np.full(size, upper) - x.values)
    return damped_step(
        assemble(terms, x),
        lambda candidate: energy_of(terms, candidate),
        x,
        scaling=np.ones(size),
        damping=damping,
        least_damping=damping if least is None else least,
        bounds=bounds,
        free=np.ones(size, dtype=bool),
    )


def test_small_and_large_terms_add_up_the_same(rng: np.random.Generator) -> None:
    terms = [term(rng, rows) for rows in (2, 40, 3, 6)]
    x = Flat(rng.normal(size=6))
    system = assemble(terms, x)
    jacobian = np.concatenate([one.matrix for one in terms])
    residual = np.concatenate([one.residual(x) for one in terms])
    np.testing.assert_allclose(system.hessian, jacobian.T @ jacobian, atol=1e-12)
    np.testing.assert_allclose(system.gradient, jacobian.T @ residual, atol=1e-12)
    assert system.energy == pytest.approx(0.5 * residual @ residual)


def test_one_step_solves_a_linear_problem(rng: np.random.Generator) -> None:
    problem = term(rng)
    done = step([problem], Flat(np.zeros(6)))
    expected = np.linalg.lstsq(problem.matrix, problem.right, rcond=None)[0]
    np.testing.assert_allclose(done.x.values, expected, atol=1e-9)


def test_bounds_are_kept_and_the_rest_is_optimal_inside_them_after_one_step(rng: np.random.Generator) -> None:
    problem = term(rng)
    x = step([problem], Flat(np.zeros(6)), -0.1, 0.1).x
    expected = lsq_linear(problem.matrix, problem.right, (-0.1, 0.1), tol=1e-14).x
    np.testing.assert_allclose(x.values, expected, atol=1e-9)


def test_a_stiff_joint_pulls_an_unknown_off_its_bound() -> None:
    """The energy of the first unknown pushes it against its bound at 0; the second one, joined to it, pulls harder."""
    energy = Linear(np.diag([np.sqrt(0.1), 1.0]), np.array([-np.sqrt(0.1), 1.0]))
    joint = Linear(np.array([[1e4, -1e4]]), np.zeros(1))
    done = step([energy, joint], Flat(np.zeros(2)), lower=np.array([0.0, -np.inf]))
    np.testing.assert_allclose(done.x.values, 9.0 / 11.0, atol=1e-6)  # 0.1 (x + 1) + (x − 1) = 0


@dataclass(frozen=True, eq=False)
class Curved:
    """r = atan(s x), whose full steps overshoot: the larger s, the worse."""

    steepness: float
    name: str = "curved"

    def residual(self, x: Flat) -> np.ndarray:
        return np.arctan(self.steepness * x.values)

    def linearise(self, x: Flat) -> Linearisation:
        slope = self.steepness / (1.0 + (self.steepness * x.values) ** 2)
        return Linearisation(self.residual(x), np.diag(slope))


def test_a_step_that_brings_much_less_than_promised_is_not_taken() -> None:
    """From 1.38 a full step leads to -1.36: the energy falls by a hundredth of what the model promises."""
    problem, x = Curved(1.0), Flat(np.array([1.38]))
    full = x.retract(-problem.residual(x) * (1.0 + x.values**2))
    before, after = (float(problem.residual(at) @ problem.residual(at)) for at in (x, full))
    assert 0.9 * before < after < before  # not worse, but hardly better
    done = step([problem], x, damping=1e-3)
    assert before - 2.0 * done.energy > 0.1 * before
    assert done.x.values[0] > -1.2
    assert done.damping == pytest.approx(4e-2)  # rejected once, and a poor step then


def test_the_damping_follows_the_gain_ratio() -> None:
    poor = step([Curved(1.0)], Flat(np.array([1.3])), damping=1e-3)  # to -1.16
    assert poor.damping == pytest.approx(4e-3)
    good = step([Curved(1.0)], Flat(np.array([0.1])), damping=1e-3, least=1e-6)
    assert good.damping == pytest.approx(1e-3 / 3.0)
    least = step([Curved(1.0)], Flat(np.array([0.1])), damping=1e-3, least=1e-3)
    assert least.damping == 1e-3


def test_a_number_that_is_not_finite_is_said() -> None:
    bad = Linear(np.eye(6), np.full(6, np.nan))
    assert step([bad], Flat(np.zeros(6))).status is Status.NOT_FINITE


@pytest.mark.parametrize("even", [2.0, 3.0, 8.0])
def test_the_price_of_an_outlier_is_its_mixtures_and_reweighting_lies_above_it(even: float) -> None:
    """Half r² times the weight, plus what it is short of the price there, is at least the price anywhere (EM)."""
    r = np.linspace(0.0, 12.0, 4801)
    weight, price = inlier_chance(r, even), mixture_cost(r, even)
    assert inlier_chance(np.array([even]), even)[0] == pytest.approx(0.5)
    assert (np.diff(weight) <= 0.0).all()
    np.testing.assert_allclose(np.gradient(price, r)[1:-1], (weight * r)[1:-1], atol=2e-3)  # its derivative
    assert price[0] == 0.0
    assert price[-1] == pytest.approx(outlier_cost(even), abs=1e-6)
    for at in (0.5, even, even + 1.0):
        w, p = inlier_chance(np.array([at]), even)[0], mixture_cost(np.array([at]), even)[0]
        assert (0.5 * w * (r**2 - at**2) + p >= price - 1e-9).all()
    np.testing.assert_array_equal(mixture_cost(r, None), 0.5 * r**2)
    np.testing.assert_array_equal(inlier_chance(r, None), 1.0)
