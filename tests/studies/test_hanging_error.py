"""How much farther off lines are where a breast hangs is what holds nine of ten points of the development half."""

import numpy as np
import pytest

from breastrig_studies.bodies.hanging_error import Carried, estimate, held
from breastrig_studies.cohort import DEVELOPMENT, VALIDATION


def women(half: str, hanging: float, points: list[int], seed: int) -> list[Carried]:
    """Women whose points are off by Gaussians of which radius and hanging skin together hold nine of ten."""
    rng, found = np.random.default_rng(seed), []
    for number, count in enumerate(points):
        radii = rng.uniform(0.005, 0.015, count)
        errors = np.abs(rng.normal(size=count)) * np.hypot(radii, hanging) / 1.645
        found.append(Carried(f"{half} {number}", half, "true", errors, radii))
    return found


@pytest.mark.parametrize("hanging", [0.01, 0.03])
def test_the_number_is_that_of_the_development_half_alone(hanging: float) -> None:
    own = women(DEVELOPMENT, hanging, [20_000] * 3, 1)
    others = [*women(VALIDATION, 0.1, [20_000] * 3, 2), *women("", 0.0, [20_000], 3)]
    found = estimate([*own, *others])
    assert found == pytest.approx(hanging, rel=0.05)
    assert held(own, found) == pytest.approx(0.9, abs=1e-3)
    assert held(others[:3], found) < 0.6


def test_each_woman_counts_alike_however_many_points_she_has() -> None:
    many, few = women(DEVELOPMENT, 0.0, [50_000], 1), women(DEVELOPMENT, 0.04, [500], 2)
    alone = (held(many, 0.0) + held(few, 0.0)) / 2.0
    assert held([*many, *few], 0.0) == pytest.approx(alone)
    assert estimate([*many, *few]) > 0.01


def test_where_nine_of_ten_are_held_nothing_is_added() -> None:
    sure = [Carried("a", DEVELOPMENT, "true", np.full(100, 0.004), np.full(100, 0.005))]
    assert estimate(sure) == 0.0
