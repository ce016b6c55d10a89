"""The middle of the breast bone goes most of the way to where it is expected between its ends, and only along it."""

import numpy as np
import pytest

from breastrig.fitting.body.expected_shifts import mid_sternum_step
from breastrig.relief.limits import relief

NOTCH, XIPHOID = np.array([0.0, 0.2, 0.0]), np.array([0.0, 0.0, 0.05])


@pytest.mark.parametrize("share", [0.2, 0.49, 0.7])
def test_a_middle_goes_along_the_bone_by_its_share_of_what_it_is_off(share: float) -> None:
    rules, aside = relief().mid_sternum, np.array([0.004, 0.0025, 0.01])  # at right angles to the bone
    assert aside @ (XIPHOID - NOTCH) == pytest.approx(0.0)
    step = mid_sternum_step(NOTCH, XIPHOID, NOTCH + share * (XIPHOID - NOTCH) + aside, rules)
    np.testing.assert_allclose(step, rules.share * (rules.at - share) * (XIPHOID - NOTCH), atol=1e-15)


def test_ends_at_one_place_say_nothing() -> None:
    assert not mid_sternum_step(NOTCH, NOTCH, XIPHOID, relief().mid_sternum).any()
