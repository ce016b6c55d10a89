"""The items of a plan in words and numbers, as the report shows them."""

from collections.abc import Mapping, Sequence
from typing import Any

from breastrig.core.errors import BadDrawing
from breastrig.core.stances import SIDES
from breastrig.drawings.clock import FittedSkin
from breastrig.drawings.constructions.apart import are_apart, of_side
from breastrig.drawings.handles.as_drawn import as_drawn, differs
from breastrig.drawings.pattern_parameters import PatternParameter, parameters_of
from breastrig.drawings.patterns import LABELS, PATTERNS, pattern_of
from breastrig.drawings.plan_schema import PlanItem, PlanLesion, PlanLine, PlanNote, PlanPattern, PlanTumour, asked_of
from breastrig.languages.translation import Typed
from breastrig.report.document import PlannedItem
from breastrig.report.pages.names import plainly, spoken
from breastrig.use.folder.fit_folder import FitFolder

MIRRORED = "mirrored from the other side"
REASONS = {"nipple_above_fold_mm": "a nipple is not moved down", "width_mm": "the skin bends between the limbs"}
UNITS = {"mm": " mm", "deg": "°"}
OF_SIDE = {
    "mm": {"L": "{:g} mm left", "R": "{:g} mm right"},
    "deg": {"L": "{:g}° left", "R": "{:g}° right"},
}

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
            item.text if isinstance(item, PlanNote) else "",
            _text(item, missing),
            item.id in here or item.id in missing or not isinstance(item, PlanPattern | PlanTumour),
        )
        for item in items
    )


def texts_of(items: Sequence[PlanItem]) -> list[tuple[str, str]]:
    """(what it is, text) of all that people have written into a plan."""
    found = []
    for item in items:
        if isinstance(item, PlanNote):
            found.append(("A note", item.text))
        elif isinstance(item, PlanLesion):
            found.append(("The name of a lesion", item.name))
        elif isinstance(item, PlanLine):
            found += [("The name of a line", item.name), ("The name of a line", item.label or "")]
    return found


def _name(item: PlanItem, fit: FitFolder) -> str:
    if isinstance(item, PlanLine):
        return Typed(item.label) if item.label else spoken(item.name)
    if isinstance(item, PlanLesion):
        return Typed(item.name) if item.name.lower().startswith("lesion") else f"Lesion, {item.name}"
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
    """`fit` where the item was made on its scan, and is drawn there: then the numbers are those of its lines."""
    if isinstance(item, PlanLine):
        depth = (("Depth", f"{item.depth_mm:g} mm"),) if item.depth_mm else ()
        return (*((("Drawn", MIRRORED),) if item.mirrored else ()), *depth)
    if isinstance(item, PlanLesion):
        return (("Radius", f"{item.radius_mm:.3g} mm"),)
    if not isinstance(item, PlanPattern | PlanTumour) or (isinstance(item, PlanPattern) and item.name not in PATTERNS):
        return ()
    name, given = asked_of(item)
    drawn = {} if fit is None else _as_drawn(name, given, fit)
    parameters = [each for each in parameters_of(PATTERNS[name]).values() if each.name != "side"]
    said = [(each.label, _on_sides(each, given, drawn.get(each.name, {}))) for each in parameters]
    if isinstance(item, PlanTumour):
        said.append(("Below the skin", "not known" if item.depth_mm is None else f"{item.depth_mm:g} mm"))
    return tuple((label, value) for label, value in said if value)


def _on_sides(parameter: PatternParameter, given: Mapping[str, float | str], drawn: Mapping[str, float]) -> str:
    """A parameter's value, or that of each side where right and left are apart and it differs."""
    if not are_apart(given):
        return _said(parameter, given.get(parameter.name, parameter.default), drawn)
    texts = {}
    for side, word in reversed(SIDES.items()):
        asked = of_side(given, side).get(parameter.name, parameter.default)
        texts[word] = _said(parameter, asked, {side: drawn[side]} if side in drawn else {})
    if len({*texts.values()}) == 1:
        return next(iter(texts.values()))
    return ", ".join(f"{text} {word}" for word, text in texts.items() if text)


def _said(parameter: PatternParameter, asked: float | str | None, drawn: Mapping[str, float]) -> str:
    """A parameter's drawn value; the requested one beside it, where they differ."""
    if not isinstance(asked, float | int | None) or not drawn:
        return _value(parameter, asked)
    values = [*drawn.values()]
    if asked is not None and not differs(asked, values, parameter.unit):
        return _value(parameter, asked)
    if differs(values[0], values, parameter.unit):
        text = ", ".join(_of_side(parameter, round(value, 1), side) for side, value in drawn.items())
    else:
        text = _value(parameter, round(sum(values) / len(values), 1))
    if asked is None:
        return text
    wish, why = _value(parameter, asked), REASONS.get(parameter.name, "")
    return f"{text} (asked for: {wish}; {why})" if why else f"{text} (asked for: {wish})"


def _of_side(parameter: PatternParameter, value: float, side: str) -> str:
    said = OF_SIDE.get(parameter.unit)
    return said[side].format(value) if said else f"{_value(parameter, value)} {SIDES[side]}"


def _value(parameter: PatternParameter, value: float | str | None) -> str:
    if isinstance(value, float | int):
        return clock(value) if parameter.unit == "h" else f"{value:g}{UNITS.get(parameter.unit, '')}"
    return "" if value is None else str(value)


def _as_drawn(name: str, given: Mapping[str, float | str], fit: FitFolder) -> dict[str, dict[str, float]]:
    """The numbers of its lines; none where it does not fit, which is said elsewhere."""
    try:
        return as_drawn(pattern_of(name, given), FittedSkin(fit.rig, fit.vertices, fit.seen | fit.landmarks))
    except BadDrawing:
        return {}


def _text(item: PlanItem, missing: Mapping[str, str]) -> str:
    why = f"{NOT_DRAWN}{plainly(missing[item.id])}" if item.id in missing else ""
    if isinstance(item, PlanPattern) and item.name in PATTERNS:
        for parameter in parameters_of(PATTERNS[item.name]).values():
            why = why.replace(f"{parameter.name} of {item.name}", parameter.label)
    return why


def clock(hour: float) -> str:
    """10.5: 10:30."""
    minutes = round(60.0 * hour)
    return f"{minutes // 60 or 12}:{minutes % 60:02d}"
