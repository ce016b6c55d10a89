"""Ink on painted women of whom the true lines are known, photographed and compressed as phones do."""

import numpy as np
import pytest
from helpers.painted_body import painted_body
from scipy.spatial import cKDTree

from breastrig.colour.ink.find_ink import find_ink
from breastrig.geometry.polyline import resampled

pytestmark = pytest.mark.long


@pytest.mark.parametrize("ink", ["red"])
def test_ink_is_found_and_known_on_the_darkest_skin(ink: str) -> None:
    woman = painted_body(patient=2, tone=6, plan="lumpectomy", side=1280, inks=(ink, ink))
    skin = woman.painted.skin
    lines = woman.painted.marks.ink
    whole = np.concatenate([skin.places(each.points) for each in lines])
    drawn = np.concatenate([skin.places(each.points)[each.inked] for each in lines])
    drawn = drawn[cKDTree(woman.scan.vertices).query(drawn)[0] < 6e-3]
    found = find_ink(woman.scan)
    points = np.concatenate([resampled(each.line.points, 5e-4, each.line.closed) for each in found])
    off = cKDTree(whole).query(points)[0]
    assert (cKDTree(points).query(drawn)[0] < 3e-3).mean() > 0.84  # of all drawn, also in the folds
    assert (off < 3e-3).mean() > 0.95
    assert off[off < 3e-3].mean() < 1.0e-3
    plan = [each for each in found if not each.kind.is_mark and each.length > 0.04]
    assert {each.marker.name for each in plan} == {ink}
