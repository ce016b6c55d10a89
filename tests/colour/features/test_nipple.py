"""Areolae and nipples found by colour on painted skins whose truth is known."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.painted_body import PaintedBody, painted_body

from breastrig.colour.features.limits import features
from breastrig.colour.features.nipple import AREOLA_SEEN, find_nipple
from breastrig.colour.features.observation import Expectation, Observation
from breastrig.colour.features.observe import observed_landmarks
from breastrig.colour.features.patch import ColouredSkin
from breastrig.core.arrays import Array

pytestmark = pytest.mark.long

FRONT, LEFT, UP = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
OFF = np.array([0.009, -0.011, 0.0])  # m, as far off as the form expects a nipple


def seen(woman: PaintedBody, side: str, off: Array = OFF) -> Observation | None:
    place = woman.body.landmarks[f"nipple_{side}"] + off
    return find_nipple(ColouredSkin(woman.scan), place, FRONT, UP, 0.012, features().areola)


def radius_of(rim: Array) -> float:
    around = rim - rim.mean(axis=0)
    return float(np.sqrt(0.5 * np.linalg.norm(np.cross(around, np.roll(around, -1, axis=0)), axis=1).sum() / np.pi))


@pytest.fixture(scope="module")
def woman() -> PaintedBody:
    return painted_body(tone=6, plan="lumpectomy", side=640)


def test_nipple_and_areola_are_found_on_dark_skin_with_ink(woman: PaintedBody) -> None:
    for side, rim in woman.rims.items():
        found = seen(woman, side)
        error = np.linalg.norm(found.place - woman.body.landmarks[f"nipple_{side}"])
        assert error < 0.006
        assert error < 3.0 * np.sqrt(np.trace(found.covariance))
        assert found.areola.radius == pytest.approx(radius_of(rim), abs=0.0025)  # the triangles are 10 mm large
        across = (found.areola.centre - rim.mean(axis=0)) @ (np.eye(3) - np.outer(*2 * [found.areola.normal]))
        assert np.linalg.norm(across) < 0.003


def test_a_covered_and_a_reconstructed_nipple_are_not_seen() -> None:
    woman = painted_body(tone=4, states=(("L", "covered"), ("R", "reconstructed")))
    assert seen(woman, "L") is None
    assert seen(woman, "R") is None


def expectations(woman: PaintedBody, **places: Array) -> dict[str, Expectation]:
    return {name: Expectation(place, FRONT, 0.012) for name, place in places.items()}


def test_sides_keep_their_names_and_one_areola_is_never_both(woman: PaintedBody) -> None:
    left, right = (woman.body.landmarks[f"nipple_{side}"] for side in "LR")
    found = observed_landmarks(woman.scan, expectations(woman, nipple_L=left, nipple_R=right), LEFT, UP)
    assert set(found) == {"nipple_L", "nipple_R"}
    assert np.linalg.norm(found["nipple_L"].place - left) < 0.006
    assert found["nipple_L"].reason == AREOLA_SEEN
    exchanged = observed_landmarks(woman.scan, expectations(woman, nipple_L=right, nipple_R=left), LEFT, UP)
    assert not exchanged  # colour finds both, but the wrong way round
    doubled = observed_landmarks(woman.scan, expectations(woman, nipple_L=left, nipple_R=left), LEFT, UP)
    assert not doubled


def test_an_areola_where_the_form_rules_it_out_is_not_taken(woman: PaintedBody) -> None:
    assert seen(woman, "L", np.array([-0.045, 0.02, 0.0])) is None


def test_a_scan_without_colour_shows_nothing(woman: PaintedBody) -> None:
    plain = replace(woman.scan, texture=None, uv=None, picture=None)
    place = woman.body.landmarks["nipple_L"]
    assert observed_landmarks(plain, expectations(woman, nipple_L=place), LEFT, UP) == {}
    broken = replace(woman.scan, picture=b"\xff\xd8\xff no picture")
    assert observed_landmarks(broken, expectations(woman, nipple_L=place), LEFT, UP) == {}
