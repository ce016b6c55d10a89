"""Points that stand for all."""

import numpy as np

from breastrig.geometry.spread_out import spread_out


def test_spread_out_points_are_far_from_each_other() -> None:
    line = np.linspace(0.0, 1.0, 101)[:, None] * [1.0, 0.0, 0.0]
    assert sorted(line[spread_out(line, 3)][:, 0]) == [0.0, 0.5, 1.0]
    assert len(spread_out(line, 500)) == 101
