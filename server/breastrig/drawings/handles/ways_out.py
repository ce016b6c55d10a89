"""What goes where a planned pattern does not: offered only after it has been drawn on the patient's own body."""

from collections.abc import Iterator
from dataclasses import dataclass

from breastrig.core.errors import BadDrawing
from breastrig.core.stances import SIDES
from breastrig.drawings.clock import FittedSkin
from breastrig.drawings.constructions.apart import of_side, parted
from breastrig.drawings.patterns import PATTERNS, able_patterns, pattern_of
from breastrig.drawings.plan_schema import PlanPattern

Parameters = dict[str, float | str]

NEXT = {"reduction": ("vertical", "Vertical pattern"), "vertical": ("periareolar", "Around the areola")}  # less room
SMALLER_AREOLAS = (38.0, 34.0, 30.0)  # mm; 40 to 45 is usual, and none is sewn below 30
MOST = 3  # of one refusal: more are no help


@dataclass(frozen=True)
class WayOut:
    """A pattern with its parameters, and what a button says of it."""

    label: str
    name: str
    parameters: Parameters


def side_alone(skin: FittedSkin, item: PlanPattern, side: str) -> PlanPattern | BadDrawing:
    """The item on one side, or why it does not fit there."""
    alone = item.model_copy(update={"parameters": of_side(item.parameters, side)})
    refused = _refused(skin, alone.name, alone.parameters)
    return alone if refused is None else refused


def ways_out(skin: FittedSkin, item: PlanPattern) -> tuple[WayOut, ...]:
    """At most MOST of them, the least change first; none for a drawing of the model, which has no parameters."""
    found: list[WayOut] = []
    for way in _thought_of(skin, item):
        if len(found) < MOST and way.name not in {each.name for each in found if each.name != item.name}:
            found += [way] if _refused(skin, way.name, way.parameters) is None else []
    return tuple(found)


def _thought_of(skin: FittedSkin, item: PlanPattern) -> Iterator[WayOut]:
    given: Parameters = dict(item.parameters)
    if item.name not in able_patterns(skin.rig):
        return
    without = _without(given, "limb_mm")
    if without != given:
        yield WayOut("Shorter limbs", item.name, without)
    if item.name in NEXT:
        name, label = NEXT[item.name]
        yield WayOut(
            label, name, {key: value for key, value in given.items() if parted(key)[0] in PATTERNS[name].model_fields}
        )
    smaller = _smaller_areola(skin, item.name, given)
    if smaller is not None:
        yield WayOut(f"Areola of {smaller['areola_mm']:g} mm", item.name, smaller)
    if given.get("side", "both") == "both":
        for side, word in SIDES.items():
            yield WayOut(f"The {word} side only", item.name, of_side(given, side))


def _smaller_areola(skin: FittedSkin, name: str, given: Parameters) -> Parameters | None:
    field = PATTERNS[name].model_fields.get("areola_mm")
    if field is None:
        return None
    asked = max(float(of_side(given, side).get("areola_mm", field.default)) for side in SIDES)
    tries = (_without(given, "areola_mm") | {"areola_mm": mm} for mm in SMALLER_AREOLAS if mm < asked)
    return next((each for each in tries if _refused(skin, name, each) is None), None)


def _without(given: Parameters, name: str) -> Parameters:
    """The parameters without this one, on either side."""
    return {key: value for key, value in given.items() if parted(key)[0] != name}


def _refused(skin: FittedSkin, name: str, parameters: Parameters) -> BadDrawing | None:
    """Why this cannot be drawn; None where it can."""
    try:
        pattern_of(name, parameters).drawn(skin)
    except BadDrawing as error:
        return error
    return None
