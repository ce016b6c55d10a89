"""Numbers of one side alone: each breast is as if it were planned alone, whatever says so and whoever reads it."""

from types import SimpleNamespace

import numpy as np
import pytest

from breastrig.core.errors import BadDrawing
from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.clock import FittedSkin
from breastrig.drawings.handles.as_drawn import as_drawn
from breastrig.drawings.handles.live_pattern import Drag, LiveSkin, Parameters
from breastrig.drawings.patterns import asked_drawing, pattern_of
from breastrig.drawings.plan_on_scan import PlannedScan, plan_on_scan
from breastrig.drawings.plan_schema import PlanPattern, checked_plan
from breastrig.drawings.skin_maps.skin_map import FittedScan
from breastrig.rig.model import Rig
from breastrig.rig.parameters import rest_parameters
from breastrig.rig.skinning import shaped
from breastrig.use.lines.plan_words import planned_items

APART: list[tuple[str, Parameters]] = [
    ("reduction", {"areola_mm": 40.0, "limb_mm": 40.0, "limb_mm_left": 36.0, "nipple_outward_mm_right": 8.0}),
    ("vertical", {"width_mm": 60.0, "width_mm_left": 44.0}),
    ("periareolar", {"outer_mm_right": 70.0, "lift_mm_left": 20.0}),
    ("ellipse", {"width_mm_left": 60.0, "width_mm_right": 80.0}),
]


def alone(parameters: Parameters, side: str) -> Parameters:
    own, other = {"L": ("_left", "_right"), "R": ("_right", "_left")}[side]
    kept = {key: value for key, value in parameters.items() if not key.endswith((own, other))}
    kept |= {key.removesuffix(own): value for key, value in parameters.items() if key.endswith(own)}
    return kept | {"side": side}


@pytest.fixture(scope="module")
def vertices(torso: Rig) -> np.ndarray:
    weights = rest_parameters(torso).weights.copy()
    for name, weight in (("ptosis", 1.8), ("volume_large", 1.5), ("nipple_vertical", -1.4)):
        for side in ("_L", "_R"):
            weights[torso.shape_names.index(name + side)] = weight
    return 1.15 * shaped(torso, weights)


@pytest.mark.parametrize(("name", "parameters"), APART)
def test_each_side_is_drawn_and_measured_as_if_it_were_planned_alone(
    torso: Rig, vertices: np.ndarray, name: str, parameters: Parameters
) -> None:
    skin = FittedSkin(torso, vertices)
    text = f"{name}:{','.join(f'{key}={value}' for key, value in parameters.items())}"
    drawn = {shape.name: skin.at(shape.points) for shape in asked_drawing(torso, text).on_skin(skin).shapes}
    measured = as_drawn(pattern_of(name, parameters), skin)
    count = 0
    for side in "LR":
        own = pattern_of(name, alone(parameters, side))
        for shape in own.drawn(skin):
            assert np.array_equal(drawn[shape.name], skin.at(shape.points))
            count += 1
        assert {key: sides[side] for key, sides in measured.items()} == {
            key: sides[side] for key, sides in as_drawn(own, skin).items()
        }
    assert count == len(drawn)


def test_a_drag_where_sides_are_apart_changes_the_number_of_its_own_side(torso: Rig, vertices: np.ndarray) -> None:
    scan = FittedScan(ScanTarget(vertices, torso.faces), vertices, {}, "standing", None)
    live, parameters = LiveSkin(torso, scan), {"areola_mm": 42.0, "areola_mm_left": 36.0, "limb_mm": 36.0}
    first = live.drawn("reduction", parameters)
    handles = {each.handle.name: each for each in first.handles}
    assert [handles[f"areola_{side}"].numbers[0].value for side in "LR"] == [36.0, 42.0]
    assert {each.handle.side for each in first.handles} == {"L", "R"}
    at = handles["areola_R"]
    found = live.drawn("reduction", parameters, drag=Drag("areola_R", tuple(at.at + 0.003 * at.handle.grows)))
    assert {*found.parameters} == {*parameters, "areola_mm_right"}
    assert 45.0 < float(found.parameters["areola_mm_right"]) < 52.0
    assert {key: found.parameters[key] for key in parameters} == parameters
    assert {line.name[-1] for line, _ in found.lines} == {"R"}


def test_what_does_not_fit_with_the_numbers_of_its_side_is_drawn_on_the_other_and_ways_out_hold(torso: Rig) -> None:
    rest = shaped(torso, rest_parameters(torso).weights)
    scan = FittedScan(ScanTarget(rest, torso.faces), rest, {}, "standing", None)
    item = PlanPattern(id="p", name="reduction", parameters={"limb_mm_left": 78.0, "areola_mm_right": 38.0})
    found = plan_on_scan(torso, PlannedScan("standing", scan, [item]), [])
    [missing] = found.missing
    assert missing.reason.startswith("No room on the left: limbs of 78 mm")
    assert {each.line.name[-1] for each in found.lines} == {"R"}
    ways = {way.label: way for way in missing.instead}
    assert ways["Shorter limbs"].parameters == {"areola_mm_right": 38.0}
    skin = FittedSkin(torso, rest)
    for way in missing.instead:
        assert pattern_of(way.name, way.parameters).drawn(skin), way.label


def test_the_report_says_the_numbers_of_each_side_where_they_differ(torso: Rig, vertices: np.ndarray) -> None:
    parameters = {"areola_mm": 42.0, "areola_mm_left": 36.0, "limb_mm": 40.0}
    item = {"id": "a", "kind": "pattern", "name": "reduction", "parameters": parameters}
    plan = checked_plan({"schema": "breastrig/plan@1", "unit": "mm", "items": [item]})
    fit = SimpleNamespace(rig=torso, vertices=vertices, seen={}, landmarks={})
    for here in ([{"item": "a", "carried": False}], []):
        (said,) = planned_items(plan.items, {"shapes": here}, {}, fit)
        assert said.name.endswith("both breasts")
        values = dict(said.values)
        assert values["New areola"] == "42 mm right, 36 mm left"
        assert values["Vertical limbs"].startswith("40 mm") or not here


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("reduction:limbs_left=50", '"limbs_left" is not a parameter of reduction; known are: side'),
        ("reduction:side_left=both", "side of reduction has no value for each side; write side."),
        ("tumour:side=L,clock_left=10,distance_mm=45,radius_mm=12", "clock of tumour has no value for each side"),
        ("reduction:limb_mm_left=500", "On the left: limb_mm of reduction cannot be 500: input should be less than"),
        ("reduction:side=R,limb_mm_left=50", "limb_mm_left of reduction is not needed: the pattern is drawn on the"),
        ("reduction:side=M,limb_mm_left=50", "side of reduction cannot be M"),
        ("periareolar:areola_mm=40,outer_mm_left=38", "On the left: The drawing periareolar cannot be made so: the"),
    ],
)
def test_a_number_of_one_side_that_cannot_be_is_refused(torso: Rig, text: str, words: str) -> None:
    with pytest.raises(BadDrawing) as refused:
        asked_drawing(torso, text)
    assert words in str(refused.value)
    assert str(refused.value).endswith(".")


def test_of_a_pattern_on_one_side_its_own_numbers_count(torso: Rig) -> None:
    [(_, found)] = asked_drawing(torso, "reduction:side=L,limb_mm_left=41").patterns
    assert found == pattern_of("reduction", {"side": "L", "limb_mm": 41.0})
