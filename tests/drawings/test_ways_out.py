"""A pattern that fits on one side is drawn there; of the other one the plan says why not, and what would go."""

import numpy as np
import pytest

from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.clock import FittedSkin
from breastrig.drawings.patterns import pattern_of
from breastrig.drawings.plan_on_scan import PlannedScan, plan_on_scan
from breastrig.drawings.plan_schema import PlanPattern
from breastrig.drawings.skin_maps.skin_map import FittedScan
from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.skinning import shaped


def scan_of(torso: Rig, weights_of: dict[str, float]) -> FittedScan:
    weights = rest_parameters(torso).weights.copy()
    for name, weight in weights_of.items():
        weights[torso.shape_names.index(name)] = weight
    vertices = shaped(torso, weights)
    return FittedScan(ScanTarget(vertices, torso.faces), vertices, {}, "standing", None)


@pytest.mark.parametrize(
    ("small", "parameters", "offered"),
    [
        ("L", {}, {"Vertical pattern", "The right side only"}),
        ("L", {"side": "L"}, {"Vertical pattern"}),
        ("L", {"limb_mm": 75.0}, {"Vertical pattern"}),  # too long for both
    ],
)
def test_what_does_not_fit_on_one_side_is_drawn_on_the_other_and_ways_out_hold(
    torso: Rig, small: str, parameters: dict[str, float | str], offered: set[str]
) -> None:
    scan = scan_of(torso, {f"volume_large_{small}": -1.2})
    item = PlanPattern(id="p", name="reduction", parameters=parameters)
    found = plan_on_scan(torso, PlannedScan("standing", scan, [item]), [])
    words = {"L": "left", "R": "right"}
    refused = set("LR") if "limb_mm" in parameters else {small}
    assert {each.reason.split(":")[0] for each in found.missing} >= {
        f"No room {'' if 'limb_mm' in parameters else 'for a Wise pattern '}on the {words[side]}" for side in refused
    }
    drawn = {each.line.name[-1] for each in found.lines}
    asked = set("LR") if parameters.get("side") is None else {"L"}
    assert drawn == asked - refused
    ways = found.missing[0].instead
    assert all(each.instead == ways for each in found.missing)
    assert offered <= {way.label for way in ways}
    assert len(ways) <= 3
    skin = FittedSkin(torso, scan.vertices, scan.known)
    for way in ways:
        assert pattern_of(way.name, way.parameters).drawn(skin), way.label


def test_a_pattern_that_fits_asks_nothing(torso: Rig) -> None:
    scan = scan_of(torso, {})
    found = plan_on_scan(torso, PlannedScan("standing", scan, [PlanPattern(id="p", name="reduction")]), [])
    assert not found.missing
    assert {each.line.name[-1] for each in found.lines} == {"L", "R"}
    assert all(np.isfinite(each.line.points).all() for each in found.lines)
