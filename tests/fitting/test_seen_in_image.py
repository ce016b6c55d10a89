from dataclasses import replace

import numpy as np

from breastrig.colour.features.observation import Expectation
from breastrig.fitting.observed.landmarks import IN_IMAGE, seen_in_image
from breastrig.scan.piece import SeenLandmark
from breastrig.scan.scan import Scan
from breastrig.scan.stored_scan import read_stored, write_stored

PLACE = np.array([0.09, -0.18, 0.34])
SEEN = SeenLandmark("nipple_L", PLACE, 0.006)
SCAN = Scan(np.eye(3), np.array([[0, 1, 2]]), "mm", 1e-3, "", "0" * 64, from_image=True, seen=(SEEN,))


def expected(away: float) -> dict[str, Expectation]:
    return {"nipple_L": Expectation(PLACE + np.array([away, 0.0, 0.0]), np.array([0.0, -1.0, 0.0]), 0.006)}


def test_a_nipple_of_the_image_is_observed_with_its_error():
    (observed,) = seen_in_image(SCAN, expected(0.010)).values()
    np.testing.assert_array_equal(observed.place, PLACE)
    assert observed.reason == IN_IMAGE
    np.testing.assert_allclose(observed.error, 0.004)


def test_a_bump_far_from_where_the_form_has_the_nipple_is_none():
    assert seen_in_image(SCAN, expected(0.020)) == {}


def test_a_landmark_that_the_model_has_not_is_left_out():
    assert seen_in_image(replace(SCAN, seen=(SeenLandmark("ear", PLACE, 0.006),)), expected(0.0)) == {}


def test_what_the_image_shows_is_stored(tmp_path):
    write_stored(SCAN, tmp_path / "scan.stored")
    (seen,) = read_stored(tmp_path / "scan.stored").seen
    assert (seen.name, seen.radius) == ("nipple_L", 0.006)
    np.testing.assert_array_equal(seen.place, PLACE)
