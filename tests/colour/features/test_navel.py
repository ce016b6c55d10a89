"""The navel found by colour and dent on painted skins, at the height that the form does not know."""

import numpy as np
from helpers.painted_body import PaintedBody, painted_body

from breastrig.colour.features.limits import features
from breastrig.colour.features.navel import find_navel
from breastrig.colour.features.observation import Observation
from breastrig.colour.features.patch import ColouredSkin

FRONT, UP = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])


def seen(woman: PaintedBody, aside: float, higher: float) -> Observation | None:
    place = woman.body.landmarks["umbilicus"] + np.array([aside, higher, 0.0])
    return find_navel(ColouredSkin(woman.scan), place, FRONT, UP, 0.037, features().navel)


def test_the_navel_is_found_centimetres_from_where_the_form_has_it() -> None:
    woman = painted_body(tone=6, plan="lumpectomy", side=640)
    found = seen(woman, 0.004, -0.02)
    gap = np.linalg.norm(found.place - woman.body.landmarks["umbilicus"])
    assert gap < 0.007
    assert gap < 3.0 * np.sqrt(np.trace(found.covariance))


def test_on_a_belly_without_a_navel_none_is_taken() -> None:
    assert seen(painted_body(tone=6, plan="lumpectomy", side=640), 0.0, 0.115) is None  # between it and the fold
