"""The .glb of a fit: what of it is the same for all fits is made once, and no fit leaves anything of itself there."""

import numpy as np
from helpers.toy_rig import toy_rig

from breastrig.gltf.replay import fitted_glb
from breastrig.gltf.skinned import _only_the_rig
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.skinning import pose

FAR = np.array([20_000.0, 0.0, 3.0])  # m


def test_a_fit_after_another_one_is_written_as_if_it_were_the_first() -> None:
    rig = toy_rig()
    rest = rest_parameters(rig)
    far = rest.moved(np.eye(3), FAR)
    drawing = rig.drawings[0]

    def near() -> bytes:
        return fitted_glb(rig, [rest, rest], [0.0, 0.1], drawing, {"preset": "default"}, pose(rig, rest) + 1e-3)

    first = near()
    assert fitted_glb(rig, [far], [0.0], None, {"preset": "paper"}, pose(rig, far) + 2e-3) != first
    assert near() == first
    _only_the_rig.cache_clear()
    assert near() == first
