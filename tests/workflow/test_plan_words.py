"""What the report says of an item of the plan."""

from typing import Any

from breastrig.drawings.plan_schema import checked_plan
from breastrig.workflow.lines.plan_words import MIRRORED, planned_items


def test_a_mirrored_line_says_so_and_a_drawn_one_does_not() -> None:
    line = {"kind": "line", "scan": "", "closed": False, "points": [[0.0, 0.0, 0.0], [9.0, 0.0, 0.0]]}
    items: list[dict[str, Any]] = [
        line | {"id": "a", "name": "cut"},
        line | {"id": "b", "name": "cut, mirrored", "mirrored": True},
    ]
    plan = checked_plan({"schema": "breastrig/plan@1", "unit": "mm", "items": items})
    assert "mirrored" not in plan.items[0].model_dump(mode="json")
    drawn, mirrored = planned_items(plan.items, {"shapes": []}, {}, None)  # type: ignore[arg-type]
    assert drawn.values == ()
    assert mirrored.values == (("Drawn", MIRRORED),)
