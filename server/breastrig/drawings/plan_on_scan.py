"""The plan on one scan: the items made there, and all others transferred from the scan they were made on.

A pattern is drawn once, on the body on which it was planned, and then transferred like a pen's line: on the other
stance the same skin is meant, not the same construction made again.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadDrawing
from breastrig.core.stances import sides_of
from breastrig.drawings.clock import FittedSkin
from breastrig.drawings.handles.ways_out import WayOut, side_alone, ways_out
from breastrig.drawings.inks import PLAN
from breastrig.drawings.inside.lesions import LesionsOnScan, PlacedLesion, distances_to_lines
from breastrig.drawings.line_error import with_errors
from breastrig.drawings.on_skin import check_on_skin
from breastrig.drawings.patterns import PATTERNS, drawing_with
from breastrig.drawings.plan_schema import PlanItem, PlanLesion, PlanLine, PlanNote, PlanPattern, PlanTumour, asked_of
from breastrig.drawings.project_drawing import on_scan
from breastrig.drawings.skin_maps.skin_map import FittedScan
from breastrig.drawings.transfer import transferred
from breastrig.geometry.polyline import Polyline
from breastrig.rig.model import Rig
from breastrig.rig.near_breasts import OUTSIDE


@dataclass(frozen=True, eq=False)
class PlannedScan:
    """A scan with its fit, and the items that were made on it."""

    name: str  # for people: standing, supine
    scan: FittedScan
    items: Sequence[PlanItem]
    wall: Array | None = None  # (V, 3) m, its chest wall under each vertex of the model


@dataclass(frozen=True, eq=False)
class PlannedLine:
    """One line of an item on a scan."""

    item: PlanItem
    line: Polyline  # m; of a note its place alone
    part: str  # which of a pattern's lines; empty for a pen's
    is_carried: bool


@dataclass(frozen=True)
class MissingItem:
    """An item that cannot be shown on this scan, or not on one side, and why."""

    item: PlanItem
    reason: str
    instead: tuple[WayOut, ...] = ()  # what can be drawn in its place


@dataclass(frozen=True, eq=False)
class PlanOnScan:
    lines: tuple[PlannedLine, ...]
    lesions: tuple[PlacedLesion, ...]
    missing: tuple[MissingItem, ...]


def plan_on_scan(rig: Rig, here: PlannedScan, others: Sequence[PlannedScan]) -> PlanOnScan:
    """All items on the scan `here`; those of the other scans of the same patient are transferred.

    An item that cannot be drawn or transferred is missing, with the reason; the others are not affected.
    """
    lines, missing = _drawn(rig, here.scan, here.items)
    inside = LesionsOnScan(rig, here.scan, here.wall)
    lesions = inside.own(here.items)
    for other in others:
        lesions += inside.carried(other.scan, other.items)
        drawn, undrawn = _drawn(rig, other.scan, other.items)
        carried, uncarried = _carried(rig, other.scan, here.scan, drawn)
        taken = {each.line.name for each in lines}
        lines += [_named_apart(each, taken, other.name) for each in carried]
        missing += [*undrawn, *uncarried]
    outside = [each for each in lesions if each.depth < -OUTSIDE]
    missing += [MissingItem(each.item, _outside(each)) for each in outside]
    found = tuple(_with_lines(each, _unique(lines)) for each in lesions if each not in outside)
    have_circles = {each.item.id for each in lines if isinstance(each.item, PlanTumour)}
    lines += [
        PlannedLine(each.item, inside.outline(each), "projection", each.is_carried)
        for each in found
        if each.item.id not in have_circles
    ]
    return PlanOnScan(_unique(lines), found, tuple(missing))


def _with_lines(lesion: PlacedLesion, lines: Sequence[PlannedLine]) -> PlacedLesion:
    """The lesion with its distances to all planned lines that may be incisions."""
    cuts = [each.line for each in lines if isinstance(each.item, PlanLine | PlanPattern)]
    return replace(lesion, distances=(*lesion.distances, *distances_to_lines(lesion, cuts)))


def _outside(lesion: PlacedLesion) -> str:
    where = "comes to lie" if lesion.is_carried else "lies"
    return f"{lesion.item.name} {where} {-1e3 * lesion.depth:.0f} mm outside the skin; check its frame and unit."


def _drawn(rig: Rig, scan: FittedScan, items: Sequence[PlanItem]) -> tuple[list[PlannedLine], list[MissingItem]]:
    """The items on the scan that they were made on."""
    lines, missing = [], []
    skin = FittedSkin(rig, scan.vertices, scan.known)
    for item in items:
        try:
            lines += [PlannedLine(item, line, part, False) for line, part in _lines(skin, scan, item)]
        except BadDrawing as error:
            drawn, refused = _other_side(skin, scan, item)
            lines += drawn
            missing += refused or [MissingItem(item, str(error))]
    return lines, missing


def _other_side(skin: FittedSkin, scan: FittedScan, item: PlanItem) -> tuple[list[PlannedLine], list[MissingItem]]:
    """Of a pattern that does not fit: its lines on the side on which it does, why not on the others, and ways out."""
    if not isinstance(item, PlanPattern) or item.name not in PATTERNS:
        return [], []
    alone = [side_alone(skin, item, side) for side in sides_of(str(item.parameters.get("side", "both")))]
    lines = [
        PlannedLine(item, line, part, False)
        for each in alone
        if isinstance(each, PlanPattern)
        for line, part in _lines(skin, scan, each)
    ]
    ways = ways_out(skin, item)
    return lines, [MissingItem(item, str(each), ways) for each in alone if isinstance(each, BadDrawing)]


def _lines(skin: FittedSkin, scan: FittedScan, item: PlanItem) -> list[tuple[Polyline, str]]:
    if isinstance(item, PlanLine):
        line = _on_skin(item.name, item.closed, item.color, item.points, item.bridged)
        check_on_skin(line, scan.target.search.query(line.points).distances)
        error = None if item.error_mm is None else 1e-3 * np.array(item.error_mm, dtype=np.float64)  # null becomes nan
        return [(replace(line, error=error), "")]
    if isinstance(item, PlanLesion):
        return []  # its projection is drawn on each scan anew, over where it lies there
    if isinstance(item, PlanNote):
        return [] if item.point is None else [(_on_skin(item.id, False, PLAN, [item.point]), "")]
    rig, drawing = skin.rig, drawing_with(skin.rig, *asked_of(item)).on_skin(skin)
    found = with_errors(rig, scan.search(rig), scan.radii, on_scan(rig, scan.vertices, drawing, scan.target))
    return [(line, line.name) for line in found]


def _on_skin(
    name: str, closed: bool, color: str, points: Sequence[Sequence[float]], bridged: Sequence[bool] | None = None
) -> Polyline:
    places = 1e-3 * np.array(points, dtype=np.float64)
    return Polyline(name, closed, color, places, np.array(bridged or [False] * len(places), dtype=np.bool_))


def _carried(
    rig: Rig, a: FittedScan, b: FittedScan, drawn: Sequence[PlannedLine]
) -> tuple[list[PlannedLine], list[MissingItem]]:
    """The transferred items, all at once (as fast as one); each alone if that fails, so that others stay."""
    if not drawn:
        return [], []
    try:
        return _carried_together(rig, a, b, drawn), []
    except BadDrawing:
        lines, missing = [], []
        for each in drawn:
            try:
                lines += _carried_together(rig, a, b, [each])
            except BadDrawing as error:
                missing.append(MissingItem(each.item, str(error)))
        return lines, missing


def _carried_together(rig: Rig, a: FittedScan, b: FittedScan, drawn: Sequence[PlannedLine]) -> list[PlannedLine]:
    found = transferred(rig, a, b, [each.line for each in drawn])
    return [replace(each, line=there.line, is_carried=True) for each, there in zip(drawn, found, strict=True)]


def _named_apart(each: PlannedLine, taken: set[str], stance: str) -> PlannedLine:
    if each.line.name not in taken:
        return each
    return replace(each, line=replace(each.line, name=f"{each.line.name} ({stance})"))


def _unique(lines: Sequence[PlannedLine]) -> tuple[PlannedLine, ...]:
    """The items with unique names: two tumours of one breast are tumour_L and tumour_L 2."""
    seen: Counter[str] = Counter()
    result = []
    for each in lines:
        name = each.line.name
        seen[name] += 1
        result.append(each if seen[name] == 1 else replace(each, line=replace(each.line, name=f"{name} {seen[name]}")))
    return tuple(result)
