"""Which other landmark a pick could have been meant for."""

import numpy as np
import pytest

from breastrig.fitting.picks.mistakes import _near
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig


@pytest.mark.parametrize(("apart", "expected"), [(0.07, {"nipple_L"}), (0.045, set())])
def test_a_fold_is_no_mistaken_nipple_where_the_two_are_close(apart: float, expected: set[str]) -> None:
    """As on a breast that hangs: a pick 10 mm from the nipple was let go as one of it, although it was the fold's."""
    rig = read_rig(default_rig_path())
    fitted = {"inframammary_fold_L": np.zeros(3), "nipple_L": np.array([0.0, 0.0, apart])}
    pick = fitted["nipple_L"] + [0.0, 0.01, 0.005]
    near = _near(rig, "inframammary_fold_L", pick, fitted, load_recipe("default").outliers)
    assert near == expected
