"""Arms moved to where no source holds them: the trunk and its breasts stay, the arms go most of the way."""

import numpy as np
import pytest

from breastrig.core.arrays import Array
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.warped.arms import with_arms_along, with_arms_away
from breastrig_studies.virtual.warped.body import WarpedBody
from breastrig_studies.virtual.warped.numbers import draw_numbers
from breastrig_studies.virtual.warped.sources import read_sources


@pytest.fixture(scope="module")
def body() -> WarpedBody:
    source = read_sources()[1]
    lie = source.lying[0]
    standing = VirtualBody("standing", source.standing, source.landmarks(source.standing), None)
    supine = VirtualBody("supine", lie.vertices, source.landmarks(lie.vertices), lie.table)
    return WarpedBody(source, draw_numbers(np.random.default_rng(0)), lie.kind, 1, standing, supine)


def reach(body: VirtualBody, ends: Array) -> float:
    """m, how far from the midline the arms' ends are."""
    return float(np.abs(body.vertices[ends, 0]).mean())


def test_only_the_arms_move_and_they_move_to_the_other_stances_side(body: WarpedBody) -> None:
    ends = np.argsort(np.abs(body.supine.vertices[:, 0]))[-200:]
    along, away = (make(body, np.random.default_rng(1)) for make in (with_arms_along, with_arms_away))
    assert reach(along, ends) < 0.5 * (reach(body.standing, ends) + reach(body.supine, ends))
    assert reach(away, ends) > reach(body.standing, ends) + 0.3 * (
        reach(body.supine, ends) - reach(body.standing, ends)
    )
    for moved, before in ((along, body.supine), (away, body.standing)):
        trunk = np.abs(body.supine.vertices[:, 0]) < 0.1
        assert np.abs(moved.vertices - before.vertices)[trunk].max() < 1e-3
        assert (moved.stance, moved.table) == (before.stance, before.table)
        for name in ("nipple_L", "xiphoid", "umbilicus"):
            assert np.linalg.norm(moved.landmarks[name] - before.landmarks[name]) < 1e-3
