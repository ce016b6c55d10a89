"""What is printed of a pattern is what its lines measure, for every number of every pattern, or both are said."""

from types import SimpleNamespace

import numpy as np
import pytest

from breastrig.core.arrays import Array
from breastrig.core.errors import BadDrawing
from breastrig.drawings.clock import FittedSkin
from breastrig.drawings.handles.as_drawn import as_drawn, differs
from breastrig.drawings.pattern_parameters import PatternParameter, parameters_of
from breastrig.drawings.patterns import PATTERNS, pattern_of
from breastrig.drawings.plan_schema import checked_plan
from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.skinning import shaped
from breastrig.use.lines.plan_words import planned_items

NUMBERS = [
    (name, each) for name, kind in PATTERNS.items() for each in parameters_of(kind).values() if each.name != "side"
]


@pytest.fixture(scope="module")
def skin(torso: Rig) -> FittedSkin:
    """A large breast that sags, and on which every pattern has room."""
    weights = rest_parameters(torso).weights.copy()
    for name, weight in (("ptosis", 1.8), ("volume_large", 1.5), ("nipple_vertical", -1.4)):
        for side in ("_L", "_R"):
            weights[torso.shape_names.index(name + side)] = weight
    return FittedSkin(torso, 1.15 * shaped(torso, weights))


def needed(name: str, skin: FittedSkin) -> dict[str, float | str]:
    if name == "tumour":
        return {"side": "L", "clock": 10.0, "distance_mm": 45.0, "radius_mm": 12.0}
    if name == "tumour_at":
        x, y, z = 1e3 * skin.at(skin.landmark("nipple_L"))[0]
        return {"x_mm": float(x), "y_mm": float(y), "z_mm": float(z), "radius_mm": 12.0}
    return {}


def tries(parameter: PatternParameter, given: dict[str, float | str]) -> list[float]:
    """Both limits, and the middle, of what a person may type: the first of them that the breast has room for counts."""
    if parameter.min is None or parameter.max is None:
        return [float(given[parameter.name])]
    return [parameter.min, parameter.max, 0.5 * (parameter.min + parameter.max)]


@pytest.mark.parametrize(("name", "parameter"), NUMBERS, ids=[f"{name} {each.name}" for name, each in NUMBERS])
def test_every_number_of_every_pattern_is_measured_and_said(
    torso: Rig, skin: FittedSkin, name: str, parameter: PatternParameter
) -> None:
    given = needed(name, skin)
    fit = SimpleNamespace(rig=torso, vertices=skin.vertices, seen={}, landmarks={})
    for asked in tries(parameter, given):
        parameters = given | {parameter.name: asked} | ({} if given else {"side": "L"})
        try:
            found = as_drawn(pattern_of(name, parameters), skin)
        except BadDrawing:
            continue
        assert set(found) == {each for each in parameters_of(PATTERNS[name]) if each != "side"}
        drawn = [*found[parameter.name].values()]
        if name == "tumour_at":
            return  # no plan has one
        item = {"id": "a", "kind": "pattern", "name": name, "parameters": parameters}
        if name == "tumour":
            item = {"id": "a", "kind": "tumour"} | parameters
        plan = checked_plan({"schema": "breastrig/plan@1", "unit": "mm", "items": [item]})
        here = {"shapes": [{"item": "a", "carried": False}]}
        (said,) = planned_items(plan.items, here, {}, fit)
        value = dict(said.values)[parameter.label]
        assert ("asked for" in value) == differs(asked, drawn, parameter.unit), (asked, drawn, value)
        if "asked for" in value and parameter.unit == "mm":
            assert abs(float(value.split()[0]) - drawn[0]) < 1.0
        return
    pytest.fail("nothing of it can be drawn")


def test_a_nipple_that_is_not_moved_down_is_printed_where_it_is(torso: Rig) -> None:
    """It is 50 mm and more above the fold here, and 0 are asked for."""
    skin = FittedSkin(torso, np.array(torso.template))
    found = as_drawn(pattern_of("vertical", {}), skin)["nipple_above_fold_mm"]
    height = {side: 1e3 * nipple_over_fold(skin, side) for side in "LR"}
    assert min(height.values()) > 20.0
    assert found == pytest.approx(height, abs=0.5)


def nipple_over_fold(skin: FittedSkin, side: str) -> float:
    ends: list[Array] = [skin.at(skin.landmark(f"{name}_{side}"))[0] for name in ("nipple", "inframammary_fold")]
    return float((ends[0] - ends[1]) @ skin.axes[:, 1])
