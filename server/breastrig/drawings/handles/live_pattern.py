"""A pattern that follows a drag: its lines and handles, shortly after one number has changed.

The same code draws it as for a fit or a plan, so the lines are the same. Measurements on this skin are cached
(geometry/geodesic.py), unchanged lines are not projected again, and while one side is dragged only that side is drawn,
from its own landmarks.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from pydantic import BaseModel

from breastrig.core.arrays import Array
from breastrig.core.errors import BadDrawing, unknown_name
from breastrig.core.lru_cache import LruCache
from breastrig.core.stances import SIDES
from breastrig.drawings.clock import FittedSkin
from breastrig.drawings.constructions.apart import Apart, are_apart, of_side, put_apart
from breastrig.drawings.constructions.ellipse import MastectomyEllipse
from breastrig.drawings.constructions.periareolar import Periareolar
from breastrig.drawings.constructions.reduction import Reduction
from breastrig.drawings.constructions.tumour import Tumour
from breastrig.drawings.constructions.vertical import Vertical
from breastrig.drawings.handles.as_drawn import as_drawn
from breastrig.drawings.handles.handle import Handle
from breastrig.drawings.handles.reductions import vertical_handles, wise_handles
from breastrig.drawings.handles.rings import ellipse_handles, periareolar_handles, tumour_handles
from breastrig.drawings.pattern_parameters import UNITS, PatternParameter, parameters_of
from breastrig.drawings.patterns import Pattern, pattern_of
from breastrig.drawings.project_drawing import shapes_on_scan
from breastrig.drawings.skin_maps.scan_errors import radii_at
from breastrig.drawings.skin_maps.skin_map import FittedScan
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.polyline import Polyline
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rig.model import DrawnShape, Rig

Parameters = Mapping[str, float | str]

KEPT_LINES = 48  # on the scan; a pattern on both sides has eight, of some ten kilobytes each
STEPS = {"mm": 0.5, "deg": 1.0, "h": 0.05}  # to which a dragged value is rounded: what a hand can hold and a tape read
HALVINGS = 3  # between a value that can be drawn and one that cannot: an eighth of the way is left
SEAM = {"deg": 90.0, "h": 6.0}  # values that differ by more were read on both sides of where the angle begins anew
ON_SKIN = 0.05  # m from the fitted skin, as far as a hand may be beside it


@dataclass(frozen=True)
class Drag:
    """A handle, and the place to which it is dragged, m in the scan's frame."""

    handle: str
    to: tuple[float, float, float]


@dataclass(frozen=True)
class HandleOnScan:
    """A handle's place on the scan, its label and its numbers."""

    handle: Handle
    at: Array  # (3,) m on the scan's skin
    label: str
    numbers: tuple["HandleNumber", ...]


@dataclass(frozen=True)
class HandleNumber:
    """One parameter of a handle."""

    parameter: str
    label: str
    unit: str  # mm, deg or h
    value: float
    min: float | None
    max: float | None


@dataclass(frozen=True, eq=False)
class LivePattern:
    """A pattern as it is drawn, for one side or for all of it."""

    parameters: Parameters  # as given, or as dragged
    lines: tuple[tuple[Polyline, str], ...]  # on the scan, with their labels
    handles: tuple[HandleOnScan, ...]
    limit: str  # why a drag went no farther, in words; empty where it did not end
    measured: Mapping[str, Mapping[str, float]] = field(default_factory=dict)  # as_drawn.py; none while it is dragged


class LiveSkin:
    """One fitted scan, prepared for patterns; the first call takes longest. For one thread."""

    def __init__(self, rig: Rig, scan: FittedScan) -> None:
        self._rig = rig
        self._scan = scan
        self._skin = FittedSkin(rig, scan.vertices, scan.known)
        self._lines: LruCache[tuple[str, bytes, bytes], Polyline] = LruCache(KEPT_LINES)

    @cached_property
    def _normals(self) -> Array:
        return vertex_normals(self._scan.vertices, self._rig.faces)

    @cached_property
    def _model(self) -> ClosestPointSearch:
        return ClosestPointSearch(self._scan.vertices, self._rig.faces)

    def drawn(
        self, name: str, parameters: Parameters, side: str | None = None, drag: Drag | None = None
    ) -> LivePattern:
        """The pattern of this name with these parameters, or as it becomes by a drag.

        `side` (L, R) asks for that one alone; a drag draws the side of its handle.  Raises BadDrawing.
        """
        pattern = pattern_of(name, parameters)
        if drag is None:
            held = _on_side(pattern, side)
            return replace(self._live(held, parameters, ""), measured=as_drawn(held, self._skin))
        return self._dragged(name, pattern, parameters, drag)

    def ways(self, places: Array) -> list[Array]:
        """(M, 3) m each: the shortest path on the fitted skin from each of the (P, 3) m places to the next.

        BadDrawing where a place is off the skin, or where the skin ends between two.
        """
        on_skin = self._skin.nearest(places)
        if np.linalg.norm(self._skin.at(on_skin) - places, axis=1).max() > ON_SKIN:
            raise BadDrawing("A place lies off the fitted skin; measure on the body.")
        return self._skin.geodesics.paths(on_skin[:-1], on_skin[1:])

    def _dragged(self, name: str, pattern: Pattern, parameters: Parameters, drag: Drag) -> LivePattern:
        side = drag.handle[-1:]
        if side not in SIDES:
            raise BadDrawing(f'"{drag.handle}" is no handle; its name ends with the side, L or R.')
        held = _on_side(pattern, side)
        handles = {each.name: each for each in _handles(held, self._skin)}
        if drag.handle not in handles:
            raise BadDrawing(unknown_name(f"handle of {name}", drag.handle, tuple(handles)))
        place = np.array(drag.to)
        there = self._skin.nearest(place[None])
        if np.linalg.norm(self._skin.at(there)[0] - place) > ON_SKIN:
            raise BadDrawing("The handle was dragged off the fitted skin; drag it on the body.")
        handle = handles[drag.handle]
        wanted, limit = _within(pattern, handle, self._values(handle, there))
        best: LivePattern | None = None
        reached, beyond, share = 0.0, 1.0, 1.0  # of the way from the values now to the wanted ones
        for _ in range(1 + HALVINGS):
            values = {key: _between(handle.values[key], value, share, key) for key, value in wanted.items()}
            changed = {**parameters, **_said(pattern, handle, parameters, values)}
            try:
                best = self._live(_on_side(pattern_of(name, changed), side), changed, limit)
                reached = share
            except BadDrawing as error:
                limit, beyond = str(error), share
            if reached == 1.0:
                break
            share = 0.5 * (reached + beyond)
        return self._live(held, parameters, limit) if best is None else replace(best, limit=limit)

    def _values(self, handle: Handle, place: SurfacePoints) -> dict[str, float]:
        """The parameters for which the handle comes to the place.

        The handle is shown on the scan's skin, which is not quite the model's, and may stand beside what it measures.
        So the value read where it stands now differs from its own; the value at the place is corrected by that
        difference.
        """
        (stands,) = self._scan.target.search.query(handle.at[None]).points[:1]
        here, there = handle.values_at(self._skin.nearest(stands[None])), handle.values_at(place)
        off = {key: value - here[key] for key, value in handle.values.items()}
        return {key: there[key] + (gap if abs(gap) < SEAM.get(_unit(key), np.inf) else 0.0) for key, gap in off.items()}

    def _live(self, pattern: Pattern, parameters: Parameters, limit: str) -> LivePattern:
        shapes = pattern.drawn(self._skin)
        lines = self._on_scan(shapes)
        handles = _handles(pattern, self._skin)
        found = tuple((line, shape.label) for line, shape in zip(lines, shapes, strict=True))
        return LivePattern(parameters, found, self._on_skin(pattern, handles), limit)

    def _on_scan(self, shapes: tuple[DrawnShape, ...]) -> list[Polyline]:
        """The lines on the scan's skin, with errors; unchanged lines are reused."""
        keys = [(shape.name, shape.points.faces.tobytes(), shape.points.barycentric.tobytes()) for shape in shapes]
        known = {key: line for key in keys if (line := self._lines.get(key)) is not None}
        new = [shape for key, shape in zip(keys, shapes, strict=True) if key not in known]
        found = shapes_on_scan(self._rig, self._scan.vertices, self._normals, new, self._scan.target)
        for line, key in zip(found, [key for key in keys if key not in known], strict=True):
            radii = self._scan.radii
            error = None if radii is None else radii_at(self._rig, self._model, radii, line.points)
            known[key] = replace(line, error=error)
            self._lines.put(key, known[key])
        return [known[key] for key in keys]

    def _on_skin(self, pattern: Pattern, handles: list[Handle]) -> tuple[HandleOnScan, ...]:
        if not handles:
            return ()
        at = self._scan.target.search.query(np.array([handle.at for handle in handles])).points
        return tuple(_described(pattern, handle, place) for handle, place in zip(handles, at, strict=True))


def _handles(pattern: Pattern, skin: FittedSkin) -> list[Handle]:
    """The handles of a pattern; None where it has none."""
    match pattern:
        case Apart():
            return [handle for _, one in pattern.sides for handle in _handles(one, skin)]
        case Reduction():
            return wise_handles(pattern, skin)
        case Vertical():
            return vertical_handles(pattern, skin)
        case Periareolar():
            return periareolar_handles(pattern, skin)
        case MastectomyEllipse():
            return ellipse_handles(pattern, skin)
        case Tumour():
            return tumour_handles(pattern, skin)
    return []


def _on_side(pattern: Pattern, side: str | None) -> Pattern:
    """The pattern for one side alone, where it has sides; BadDrawing when it is that of the other one."""
    if isinstance(pattern, Apart):
        return pattern if side is None else dict(pattern.sides)[side]
    assert isinstance(pattern, BaseModel)
    own = getattr(pattern, "side", None)
    if side is None or own is None or own == side:
        return pattern
    if own != "both":
        raise BadDrawing(f"This pattern is drawn on the {SIDES[own]} side only.")
    one_sided: Pattern = pattern.model_copy(update={"side": side})
    return one_sided


def _field(pattern: Pattern, parameter: str) -> PatternParameter:
    if isinstance(pattern, Apart):
        pattern = pattern.sides[0][1]  # both are of one class
    assert isinstance(pattern, BaseModel)
    return parameters_of(type(pattern))[parameter]


def _described(pattern: Pattern, handle: Handle, place: Array) -> HandleOnScan:
    numbers = []
    for parameter, value in handle.values.items():
        field = _field(pattern, parameter)
        numbers.append(HandleNumber(parameter, field.label, field.unit, float(value), field.min, field.max))
    return HandleOnScan(handle, place, f"{numbers[0].label}, {SIDES[handle.side]}", tuple(numbers))


def _within(pattern: Pattern, handle: Handle, values: Mapping[str, float]) -> tuple[dict[str, float], str]:
    """The values rounded and within their limits, and a sentence where they would be beyond one."""
    found, limit = {}, ""
    for parameter, value in values.items():
        field = _field(pattern, parameter)
        most, step = np.inf if field.max is None else field.max, STEPS.get(field.unit, 0.5)
        rounded = _rounded(value, parameter)
        least = (handle.least or {}).get(parameter)
        own = None if least is None else step * np.ceil(least / step)
        ends = [end for end in (field.min, own) if end is not None]
        found[parameter] = float(np.clip(rounded, min(max(ends, default=-np.inf), most), most))
        if found[parameter] != rounded:
            words = {"mm": " mm", "deg": "°", "h": " o'clock"}[field.unit]
            stops = found[parameter] if own is None else max(found[parameter], float(own))  # as it is drawn
            limit = f"{field.label} stops at {stops:g}{words}."
    return found, limit


def _said(pattern: Pattern, handle: Handle, parameters: Parameters, values: Mapping[str, float]) -> dict[str, float]:
    """The parameters without those that the handle moves too and that keep an unspoken default.

    They are of the handle's side alone where right and left are apart.
    """
    first = next(iter(handle.values))
    own = of_side(parameters, handle.side) if are_apart(parameters) else parameters
    said = {
        key: value
        for key, value in values.items()
        if key == first or key in own or value != _field(pattern, key).default
    }
    return put_apart(said, handle.side) if are_apart(parameters) else said


def _unit(parameter: str) -> str:
    return UNITS.get(parameter.rsplit("_", 1)[-1], "")


def _rounded(value: float, parameter: str) -> float:
    step = STEPS.get(_unit(parameter), 0.5)
    return round(step * round(value / step), 6)


def _between(now: float, wanted: float, share: float, parameter: str) -> float:
    return wanted if share == 1.0 else _rounded(now + share * (wanted - now), parameter)
