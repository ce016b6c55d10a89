"""A lesion's place as radiology writes it, and what was typed of a report beside it."""

import numpy as np
import pytest

from breastrig.correspondence.target import ScanTarget
from breastrig.drawings.clock import FittedSkin, angle_of, on_clock
from breastrig.drawings.inside.lesions import LesionsOnScan
from breastrig.drawings.inside.radiology import ClockPosition, checked_radiology, quadrant
from breastrig.drawings.plan_schema import PlanLesion
from breastrig.drawings.skin_maps.skin_map import FittedScan
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.rotations import exp_so3
from breastrig.gltf.read_rig import default_rig_path, read_rig

LYING = exp_so3(np.array([1.5, 0.1, -0.2]))


@pytest.mark.parametrize(("side", "hour"), [("L", 2.0), ("L", 7.0), ("L", 12.0), ("R", 10.0), ("R", 4.5)])
@pytest.mark.parametrize("turn", [np.eye(3), LYING], ids=["standing", "lying"])
def test_a_place_below_the_skin_at_an_hour_is_said_to_be_at_that_hour(side: str, hour: float, turn: np.ndarray) -> None:
    rig = read_rig(default_rig_path())
    vertices = rig.template @ turn.T
    skin = FittedSkin(rig, vertices)
    nipple = skin.landmark(f"nipple_{side}")
    place = on_clock(skin, nipple, 0.04, np.array([angle_of(hour)]))
    center = skin.at(place)[0] - 0.012 * place.directions(vertex_normals(vertices, rig.faces), rig.faces)[0]
    item = PlanLesion(id="m", name="m", center=(1e3 * center).tolist(), radius_mm=5.0, radiology=f"{side}, {hour:g} h")
    (found,) = LesionsOnScan(rig, FittedScan(ScanTarget(vertices, rig.faces), vertices, {}, "standing")).own([item])
    assert found.clock is not None
    assert found.clock.hour is not None
    assert found.radiology is not None
    assert found.clock.side == side
    assert abs((found.clock.hour - hour + 6.0) % 12.0 - 6.0) < 0.5
    assert found.clock.distance == pytest.approx(np.linalg.norm(center - skin.at(nipple)[0]))
    assert found.radiology.agrees is True


def test_the_words_and_the_quadrants_of_both_sides() -> None:
    assert ClockPosition("L", 1.9, 0.0452).text == "left, 2 o'clock, 45 mm from the nipple"
    assert ClockPosition("R", 11.8, 0.03).text == "right, 12 o'clock, 30 mm from the nipple"
    assert ClockPosition("R", None, 0.03).text == "right, 30 mm behind the nipple"
    assert [quadrant("L", hour) for hour in (2.0, 4.0, 8.0, 11.0, 12.0)] == [
        "upper outer", "lower outer", "lower inner", "upper inner", "upper outer",
    ]  # fmt: skip
    assert [quadrant("R", hour) for hour in (10.0, 8.0, 4.0, 1.0)] == [
        "upper outer", "lower outer", "lower inner", "upper inner",
    ]  # fmt: skip


LEFT = ClockPosition("L", 2.0, 0.045)


@pytest.mark.parametrize(
    ("written", "place", "agrees"),
    [
        ("left, 2 o'clock, 45 mm", LEFT, True),
        ("LEFT 2 o’clock", LEFT, True),
        ("L 2:30, 4 cm FN", LEFT, True),
        ("left breast, upper outer quadrant", LEFT, True),
        ("left UOQ", LEFT, True),
        ("1-2 o'clock left", LEFT, True),
        ("left, 3:15", LEFT, True),  # another quadrant, and no farther than two readers are apart
        ("right, 2 o'clock", LEFT, False),
        ("right", LEFT, False),
        ("left, 5 o'clock", LEFT, False),
        ("left, 10 o'clock", LEFT, False),
        ("left lower inner quadrant", LEFT, False),
        ("LIQ", LEFT, False),
        ("right, inferolateral", ClockPosition("R", 8.0, 0.03), True),
        ("right, inferolateral", ClockPosition("R", 2.0, 0.03), False),
        ("left, 8 o'clock", ClockPosition("L", None, 0.03), True),  # behind the nipple: by its side alone
        ("left 11-1 o'clock", ClockPosition("L", 12.0, 0.03), True),
        ("links, 2 Uhr", LEFT, True),
        ("rechts, 2 Uhr", LEFT, False),
        ("sein droit, à l'union des quadrants", LEFT, False),
        ("mama derecha, 2 horas", LEFT, False),
        ("vasen, 2 o'clock", LEFT, None),  # the hour agrees, but of a side nothing was read
        ("2 o'clock", LEFT, None),
        ("45 mm", LEFT, None),
        ("left and right", LEFT, None),
        ("14 o'clock", LEFT, None),
        ("birads 4", LEFT, None),
    ],
)
def test_side_and_quadrant_are_compared(written: str, place: ClockPosition, agrees: bool | None) -> None:
    found = checked_radiology(written, place, is_carried=False)
    assert found.agrees is agrees, found.text
    assert found.text.endswith(".") or found.text.endswith('".')


def test_a_contradiction_says_both_and_another_stance_is_compared_by_its_side_alone() -> None:
    said = checked_radiology("left, 7 o'clock", LEFT, is_carried=False)
    assert said.text == "Radiology wrote 7 o'clock; this lesion lies at 2 o'clock (upper outer)."
    said = checked_radiology("left lower outer", LEFT, is_carried=False)
    assert said.text == "Radiology wrote lower outer; this lesion lies at 2 o'clock (upper outer)."
    said = checked_radiology("R 7 o'clock", LEFT, is_carried=True)
    assert (said.agrees, said.text) == (False, "Radiology wrote right; this lesion lies in the left breast.")
    assert checked_radiology("left, 7 o'clock", LEFT, is_carried=True).agrees is True
