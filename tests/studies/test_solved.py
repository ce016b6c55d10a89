"""A woman of the cohort that is solved under gravity."""

import pytest

from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters
from breastrig.volume.breast_skin import breast_skins
from breastrig.volume.tetrahedra import chest_wall
from breastrig_studies.gravity import solved as study


def test_the_wall_under_the_template_is_the_rigs_and_larger_breasts_leave_it_where_it_is(rig: Rig) -> None:
    wall = chest_wall(rig, rest_parameters(rig), rig.template)
    assert study.carried_wall(rig, rig.template, 1.0) == pytest.approx(wall, abs=1e-9)
    larger = rig.template.copy()
    for side in breast_skins(rig):
        larger[side.skin[side.breast]] += 0.4 * side.heights(rig.template)[side.breast]
    assert study.carried_wall(rig, larger, 1.0) == pytest.approx(wall, abs=1e-9)
