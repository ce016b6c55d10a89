"""What the report says of an item of the plan."""

from typing import Any

from breastrig.drawings.plan_schema import checked_plan
from breastrig.use.lines.plan_words import MIRRORED, planned_items


def test_a_mirrored_line_says_so_and_a_drawn_one_does_not() -> None:
    line = {"kind": "line", "scan": "", "closed": False, "points": [[0.0, 0.0, 0.0], [9.0, 0.0, 0.0]]}
    items: list[dict[str, Any]] = [
        line | {"id": "a", "name": "cut"},
        line | {"id": "b", "name": "cut, mirrored", "mirrored": True},
    ]
    plan = checked_plan({"schema": "breastrig/plan@1", "unit": "mm", "items": items})
    assert "mirrored" not in plan.items[0].model_dump(mode="json")
    drawn, mirrored = planned_items(plan.items, {"shapes": []}, {}, None)
    assert drawn.values == ()
    assert mirrored.values == (("Drawn", MIRRORED),)


def test_numbers_of_what_is_not_drawn_here_are_as_asked_for_and_only_carried_ones_are_of_another_scan() -> None:
    tumour = {"id": "t", "kind": "tumour", "side": "L", "clock": 10.0, "distance_mm": 45.0, "radius_mm": 12.0}
    plan = checked_plan({"schema": "breastrig/plan@1", "unit": "mm", "items": [tumour]})
    carried = {"shapes": [{"item": "t", "carried": True}]}
    (there,) = planned_items(plan.items, carried, {}, None)
    (missing,) = planned_items(plan.items, {"shapes": []}, {"t": "It is not on that breast."}, None)
    assert not there.is_drawn
    assert missing.is_drawn
    assert missing.said == "Not drawn: It is not on that breast."
    assert dict(missing.values)["From the nipple"] == "45 mm"
