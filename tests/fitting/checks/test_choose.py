"""Promised narrowing is that of the Gaussian with the observation in it, and the best landmark comes first."""

import numpy as np
import pytest

from breastrig.core.arrays import Array
from breastrig.drawings.line_error import across, fingers
from breastrig.fitting.checks.choose import (
    MOST,
    Check,
    Gaussian,
    ModelLine,
    Observable,
    Widths,
    asked_checks,
    mean_square,
    next_checks,
    widest,
)

LANDMARKS, VERTICES, UNKNOWNS = 5, 7, 12
PICK = 1.0 / 0.0016**2


class Toy:
    """A linear model whose normal equations can be solved again with any observation in them."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        root = rng.normal(size=(3 * UNKNOWNS, UNKNOWNS))
        self.hessian = 1e4 * root.T @ root
        self.landmarks, self.vertices = (rng.normal(size=(3 * n, UNKNOWNS)) for n in (LANDMARKS, VERTICES))
        self.replaced = np.zeros((LANDMARKS, 3, 3))
        seen = rng.normal(size=(3, 3))
        self.replaced[2] = 1e3 * seen @ seen.T  # what colours show of one
        rows = self.rows(2)
        self.hessian = self.hessian + rows.T @ self.replaced[2] @ rows
        spread = rng.normal(size=(LANDMARKS, 3, 3)) * rng.uniform(0.001, 0.01, size=(LANDMARKS, 1, 1))
        self.beside = spread @ spread.transpose(0, 2, 1)
        self.lines = [  # two on one side each, and one over both
            ModelLine(rng.integers(first, last, size=(9, 3)), rng.dirichlet(np.ones(3), size=9), times, beyond)
            for first, last, times, beyond in ((0, 4, 1.0, 0.0), (4, VERTICES, 0.7, 1e-5), (0, VERTICES, 1.0, 0.0))
        ]
        self.widths = Widths(self.lines, rng.uniform(1.0, 3.0, size=VERTICES), 0.002)

    def rows(self, index: int) -> Array:
        return self.landmarks[3 * index : 3 * index + 3]

    def gaussian(self, hessian: Array | None = None) -> Gaussian:
        covariance = np.linalg.inv(self.hessian if hessian is None else hessian)
        cross = self.vertices @ covariance @ self.landmarks.T
        own = np.diag(self.vertices @ covariance @ self.vertices.T).reshape(-1, 3).sum(axis=1)
        joint = self.landmarks @ covariance @ self.landmarks.T
        return Gaussian(joint, cross.reshape(VERTICES, 3, -1), own)

    @property
    def observable(self) -> Observable:
        partners = {0: (1, 1.0 / 0.002**2), 1: (0, 1.0 / 0.002**2)}
        return Observable(tuple("abcde"), np.array([1, 1, 1, 0, 1], bool), PICK, self.replaced, partners, self.beside)

    def solved_again(self, picks: list[int], *, on_bodies: bool = False) -> Gaussian:
        """With these picks as rows of the normal equations, and what they tell of their partners."""
        hessian, shared = self.hessian, None
        for index in picks:
            rows = self.rows(index)
            replaced = self.replaced[index]
            if index in (0, 1):
                other = self.rows(1 - index)
                if shared is None:
                    shared = other.T @ other / 0.002**2
                    hessian = hessian + shared
                else:
                    hessian = hessian - shared
            beside = self.beside[index] if on_bodies else 0.0
            hessian = hessian + rows.T @ (np.linalg.inv(np.eye(3) / PICK + beside) - replaced) @ rows
        return self.gaussian(hessian)


def close(found: Gaussian, wanted: Gaussian) -> None:
    for name in ("landmarks", "cross", "vertices"):
        values, true = getattr(found, name), getattr(wanted, name)
        np.testing.assert_allclose(values, true, rtol=1e-9, atol=1e-9 * np.abs(true).max(), err_msg=name)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("picks", [[0], [2], [4, 2], [0, 1], [1, 2, 0]])
def test_an_observed_landmark_leaves_what_normal_equations_with_it_leave(seed: int, picks: list[int]) -> None:
    """Whether it replaces an observation, tells of its partner, or knew of it."""
    toy = Toy(seed)
    known, observable = toy.gaussian(), toy.observable
    on_bodies = known
    for index in picks:
        observable, added, as_seen = observable.picked(index)
        known, on_bodies = known.with_information(added), on_bodies.with_information(as_seen)
    close(known, toy.solved_again(picks))
    close(on_bodies, toy.solved_again(picks, on_bodies=True))
    assert not observable.open[picks].any()


@pytest.mark.parametrize("seed", range(6))
def test_each_check_is_the_best_of_all_after_those_before(seed: int) -> None:
    toy = Toy(seed)
    found: list[int] = []
    for check in next_checks(toy.gaussian(), toy.observable, toy.widths):
        open_ones = {0, 1, 2, 4} - {*found}
        left = {k: toy.widths.radii(toy.solved_again([*found, k], on_bodies=True).vertices) for k in open_ones}
        assert check.index == min(left, key=lambda k: mean_square(left[k]))
        found.append(check.index)
        stated = toy.widths.radii(toy.solved_again(found).vertices)
        assert check.width == pytest.approx(widest(stated), rel=1e-9), "as the fit will have it"
    assert sorted(found) == [0, 1, 2, 4], "all that the scan shows and nobody has picked"


def test_a_width_is_the_line_error_of_radii_between_the_vertices() -> None:
    toy = Toy(0)
    variances = toy.gaussian().vertices
    vertices = np.hypot(toy.widths.factors * np.sqrt(variances), 0.002)
    first, second, both = toy.widths.radii(variances)
    line = toy.lines[1]
    at = np.einsum("mc,mc->m", line.shares, vertices[line.corners])
    np.testing.assert_allclose(second, np.sqrt((0.7 * at) ** 2 + 1e-5))
    assert widest([first, second, both]) == max(across(first), across(second), across(both))


def steps(*widths_mm: float) -> list[Check]:
    return [Check(k, 1e-3 * width) for k, width in enumerate(widths_mm)]


def test_no_more_is_asked_than_the_fingers_that_are_gained_take() -> None:
    """One finger is ±10 mm, two are ±20; beyond, ±10 mm less is a finger, too."""
    two = asked_checks(0.024, iter(steps(21.0, 15.0, 12.0)))
    assert ([each.index for each in two.asked], two.worth_it) == ([0, 1], True)
    assert len(asked_checks(0.024, iter(steps(21.0, 15.0, 9.0))).asked) == 3
    assert len(asked_checks(0.034, iter(steps(23.5, 22.0, 21.0))).asked) == 1
    small = asked_checks(0.0155, iter(steps(14.0, 12.0, 11.8)))
    assert ([each.index for each in small.asked], small.worth_it) == ([0, 1], False), "the last buys too little"
    assert asked_checks(0.0098, iter(steps(9.7))).asked == ()
    assert len(asked_checks(0.09, iter(steps(80.0, 70.0, 60.0, 5.0))).asked) == MOST


def test_fingers_are_counted_as_they_lie_across_a_line() -> None:
    assert [fingers(1e-3 * each) for each in (0.0, 4.0, 10.0, 10.1, 20.0, 20.1, 90.0)] == [1, 1, 1, 2, 2, 3, 3]
