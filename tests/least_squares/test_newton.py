"""The step of the solver on problems whose answer is known."""

from dataclasses import dataclass

import numpy as np
import pytest

from breastrig.least_squares.newton import Bounds, Status, assemble, newton_step
from breastrig.least_squares.problem import Linearisation
from breastrig.least_squares.robust import KERNELS


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
    """r = A x − b, as a term or as a constraint."""

    matrix: np.ndarray
    right: np.ndarray
    compliance: np.ndarray
    name: str = "linear"

    def residual(self, x: Flat) -> np.ndarray:
        return self.matrix @ x.values - self.right

    def linearise(self, x: Flat) -> Linearisation:
        return Linearisation(self.residual(x), self.matrix)


def term(rng: np.random.Generator, rows: int = 12, columns: int = 6) -> Linear:
    return Linear(rng.normal(size=(rows, columns)), rng.normal(size=rows), np.zeros(0))


def step(terms, constraints, x, lower=-np.inf, upper=np.inf, damping=1e-12):
    size = x.dof
    bounds = Bounds(np.full(size, lower) - x.values, np.full(size, upper) - x.values)
    free = np.ones(size, dtype=bool)
    return newton_step(terms, constraints, x, scaling=np.ones(size), damping=damping, bounds=bounds, free=free)


def test_small_and_large_terms_add_up_the_same(rng: np.random.Generator) -> None:
    terms = [term(rng, rows) for rows in (2, 40, 3, 6)]
    x = Flat(rng.normal(size=6))
    system = assemble(terms, [], x)
    jacobian = np.concatenate([one.matrix for one in terms])
    residual = np.concatenate([one.residual(x) for one in terms])
    np.testing.assert_allclose(system.hessian, jacobian.T @ jacobian, atol=1e-12)
    np.testing.assert_allclose(system.gradient, jacobian.T @ residual, atol=1e-12)
    assert system.energy == pytest.approx(0.5 * residual @ residual)


def test_one_step_solves_a_linear_problem(rng: np.random.Generator) -> None:
    problem = term(rng)
    done = step([problem], [], Flat(np.zeros(6)))
    expected = np.linalg.lstsq(problem.matrix, problem.right, rcond=None)[0]
    np.testing.assert_allclose(done.x.values, expected, atol=1e-9)


def test_a_hard_constraint_is_met_exactly(rng: np.random.Generator) -> None:
    problem = term(rng)
    hard = Linear(rng.normal(size=(2, 6)), rng.normal(size=2), np.zeros(2))
    done = step([problem], [hard], Flat(np.zeros(6)))
    np.testing.assert_allclose(hard.residual(done.x), 0.0, atol=1e-8)


def test_a_compliant_constraint_equals_an_elastic_energy(rng: np.random.Generator) -> None:
    problem = term(rng)
    soft = Linear(rng.normal(size=(2, 6)), rng.normal(size=2), np.array([0.3, 0.01]))
    done = step([problem], [soft], Flat(np.zeros(6)))
    scaled = np.sqrt(soft.compliance)
    matrix = np.concatenate([problem.matrix, soft.matrix / scaled[:, None]])
    right = np.concatenate([problem.right, soft.right / scaled])
    np.testing.assert_allclose(done.x.values, np.linalg.lstsq(matrix, right, rcond=None)[0], atol=1e-8)


def test_bounds_are_kept_and_the_rest_is_optimal_inside_them(rng: np.random.Generator) -> None:
    problem = term(rng)
    x = Flat(np.zeros(6))
    for _ in range(8):
        x = step([problem], [], x, -0.1, 0.1).x
    from scipy.optimize import lsq_linear

    expected = lsq_linear(problem.matrix, problem.right, (-0.1, 0.1)).x
    np.testing.assert_allclose(x.values, expected, atol=1e-6)


def test_a_number_that_is_not_finite_is_said() -> None:
    bad = Linear(np.eye(6), np.full(6, np.nan), np.zeros(0))
    assert step([bad], [], Flat(np.zeros(6))).status is Status.NOT_FINITE


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_robust_weight_is_one_at_zero_and_never_grows(kernel: str) -> None:
    r = np.linspace(0, 5, 101)
    weight = KERNELS[kernel](r)
    assert weight[0] == 1.0
    assert (np.diff(weight) <= 1e-15).all()
    assert (weight >= 0).all()
