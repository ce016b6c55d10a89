"""The tip of a lying shoulder follows how high the arm lies, and is none where the lengths are no lying body's."""

import numpy as np
import pytest

from breastrig.core.arrays import Array
from breastrig.relief.limits import relief
from breastrig.relief.shoulder import lying_tip

RULES = relief().lying_shoulder
NOTCH = np.array([0.01, 1.2, 0.05])
TIP = NOTCH + np.array([0.15, 0.01, -0.056])  # a usual one


def tip(tip: Array = TIP, arm_high: float = -0.03) -> Array | None:
    return lying_tip(NOTCH, tip, NOTCH + np.array([0.22, -0.05, arm_high]), RULES)


def test_the_higher_the_arm_lies_the_farther_inwards_is_the_tip() -> None:
    low, high = tip(arm_high=-0.04), tip(arm_high=-0.02)
    assert low is not None
    assert high is not None
    assert (high - low)[0] == pytest.approx(0.02 * RULES.outwards[3])
    assert (high - low)[0] < -0.015
    assert low[1] == high[1] == TIP[1]  # of the height along the body it says nothing


def test_a_form_that_has_slid_is_brought_back_part_of_the_way() -> None:
    near, far = tip(), tip(TIP + np.array([0.02, 0.0, 0.0]))
    assert near is not None
    assert far is not None
    assert np.linalg.norm(near - TIP) < 0.01  # a usual one stays about where it is
    assert 0.0 < far[0] - near[0] < 0.012
    front = tip(TIP + np.array([0.0, 0.0, 0.02]))
    assert front is not None
    assert 0.0 < front[2] - near[2] < 0.008


def test_where_body_and_scan_stand_makes_no_difference() -> None:
    there, here = lying_tip(NOTCH, TIP, TIP, RULES), lying_tip(NOTCH - NOTCH, TIP - NOTCH, TIP - NOTCH, RULES)
    assert there is not None
    assert here is not None
    np.testing.assert_allclose(there - NOTCH, here, atol=1e-12)


def test_arms_that_lie_as_nobody_s_do_tell_nothing() -> None:
    assert tip(arm_high=-0.10) is None
    assert tip(arm_high=0.10) is None
