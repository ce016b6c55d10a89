"""Where the paper's weights may begin."""

import numpy as np
import pytest
from scipy.optimize import minimize

from breastrig.fitting.body.expected_body import onto_simplex


@pytest.mark.parametrize("seed", range(4))
def test_weights_begin_at_the_nearest_ones_that_are_allowed(seed: int) -> None:
    weights = np.random.default_rng(seed).normal(0.3, 0.5, 6)
    found = minimize(
        lambda x: ((x - weights) ** 2).sum(),
        np.full(6, 0.1),
        bounds=[(0.0, None)] * 6,
        constraints={"type": "ineq", "fun": lambda x: 1.0 - x.sum()},
        options={"ftol": 1e-14},
    )
    assert onto_simplex(weights) == pytest.approx(found.x, abs=1e-5)
