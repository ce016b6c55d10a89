"""The items of a plan in words and numbers, as the report shows them."""

from collections.abc import Mapping, Sequence
from typing import Any

from breastrig.core.stances import SIDES
from breastrig.drawings.pattern_parameters import PatternParameter, parameters_of
from breastrig.drawings.patterns import LABELS, PATTERNS, drawing_with
from breastrig.drawings.plan_schema import PlanItem, PlanLesion, PlanLine, PlanNote, PlanPattern, PlanTumour, asked_of
from breastrig.report.document import PlannedItem
from breastrig.report.pages.names import plainly, spoken
from breastrig.workflow.folder.fit_folder import FitFolder

MIRRORED = "mirrored from the other side"
UNITS = {"mm": " mm", "deg": "°"}

NOT_DRAWN = "Not drawn: "


def planned_items(
    items: Sequence[PlanItem], shown: Mapping[str, Any], missing: Mapping[str, str], fit: FitFolder
) -> tuple[PlannedItem, ...]:
    """All items, each with its numbers; `shown` is the plan on this fit's scan, `missing` why others are not there."""
    here = {shape["item"] for shape in shown["shapes"] if not shape["carried"]}
    return tuple(
        PlannedItem(
            item.id,
            _name(item, fit),
            _values(item, fit if item.id in here else None),
            _text(item, missing),
        )
        for item in items
    )


def _name(item: PlanItem, fit: FitFolder) -> str:
    if isinstance(item, PlanLine):
        return item.label or spoken(item.name)
    if isinstance(item, PlanLesion):
        return f"Lesion, {item.name}"
    if isinstance(item, PlanNote):
        return "Note"
    if isinstance(item, PlanTumour):
        return f"Tumour, {SIDES[item.side]} breast"
    fixed = next((drawing.label for drawing in fit.rig.drawings if drawing.name == item.name), None)
    if fixed is not None or item.name not in PATTERNS:
        return fixed or spoken(item.name)
    side = str(item.parameters.get("side", "both"))
    return f"{LABELS[item.name]}, {'both breasts' if side == 'both' else f'{SIDES[side]} breast'}"


def _values(item: PlanItem, fit: FitFolder | None) -> tuple[tuple[str, str], ...]:
    if isinstance(item, PlanTumour):
        depth = "not known" if item.depth_mm is None else f"{item.depth_mm:g} mm"
        return (
            ("Hour", clock(item.clock)),
            ("From the nipple", f"{item.distance_mm:g} mm"),
            ("Radius", f"{item.radius_mm:g} mm"),
            ("Below the skin", depth),
        )
    if isinstance(item, PlanLine) and item.mirrored:
        return (("Drawn", MIRRORED),)
    if isinstance(item, PlanLesion):
        return (("Radius", f"{item.radius_mm:.3g} mm"),)
    if not isinstance(item, PlanPattern) or item.name not in PATTERNS:
        return ()
    parameters = [each for each in parameters_of(PATTERNS[item.name]).values() if each.name != "side"]
    given = [(each.label, _value(each, item.parameters.get(each.name, each.default))) for each in parameters]
    known = tuple((label, value) for label, value in given if value)
    return known if fit is None or len(known) == len(given) else (*known, *_as_drawn(item, fit))


def _value(parameter: PatternParameter, value: float | str | None) -> str:
    if isinstance(value, float | int):
        return clock(value) if parameter.unit == "h" else f"{value:g}{UNITS.get(parameter.unit, '')}"
    return "" if value is None else str(value)


def _as_drawn(item: PlanPattern, fit: FitFolder) -> tuple[tuple[str, str], ...]:
    """What a pattern chose itself, which its lines are labelled with: limbs of 46.5 mm."""
    drawn = drawing_with(fit.rig, *asked_of(item)).on_model(fit.rig, fit.vertices, fit.seen | fit.landmarks)
    return tuple(("As drawn", shape.label) for shape in drawn.shapes if any(map(str.isdigit, shape.label)))


def _text(item: PlanItem, missing: Mapping[str, str]) -> str:
    why = f"{NOT_DRAWN}{plainly(missing[item.id])}" if item.id in missing else ""
    if isinstance(item, PlanPattern) and item.name in PATTERNS:
        for parameter in parameters_of(PATTERNS[item.name]).values():
            why = why.replace(f"{parameter.name} of {item.name}", parameter.label)
    return f"{item.text} {why}".rstrip() if isinstance(item, PlanNote) else why


def clock(hour: float) -> str:
    """10.5: 10:30."""
    minutes = round(60.0 * hour)
    return f"{minutes // 60 or 12}:{minutes % 60:02d}"
