"""A landmark that an image shows where no body has it: it is not followed, and the result says so."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.example_image import LESIONS

import breastrig
from breastrig.scan.piece import SeenLandmark

pytestmark = pytest.mark.slow
NOT_FOLLOWED = "The image shows what may be the {}, far from where"


def test_a_bump_that_is_not_followed_is_said() -> None:
    scan = breastrig.read_scan(LESIONS)
    near = breastrig.fit(scan).landmarks
    far = near["nipple_R"] + (0.0, 0.0, 80.0)  # mm, towards the head
    seen = tuple(
        SeenLandmark(f"nipple_{side}", 1e-3 * np.array(at), 0.006) for side, at in (("L", near["nipple_L"]), ("R", far))
    )
    found = breastrig.fit(replace(scan, in_metres=replace(scan.in_metres, seen=seen)))
    said = [note for note in found.result["notes"] if note.startswith("The image shows")]
    assert [note.startswith(NOT_FOLLOWED.format("right nipple")) for note in said] == [True]
    assert "Found in the image: nipple_L." in found.result["notes"]
