"""The measures of a breast, with 90 % bands: straight as by callipers, and along the skin as by a tape.

Definitions: notch, midclavicle and fold to nipple, nipple to midline, nipple to nipple and base width as clinics take
them (Henseler 2023); symmetry ratios in symmetry.py, volume in volume.py.  Supine ones have no base width.  Landmarks
are the picked ones unless doubted, else the fitted model's; every row says which, and has its measured lines.  Lengths
along the skin are geodesic on the fitted model, as scans have holes beside and under the breast.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import SIDES
from breastrig.geometry.geodesic import Geodesics
from breastrig.geometry.polyline import length, resampled
from breastrig.geometry.surface_points import SurfacePoints, joined
from breastrig.report.bands import (
    Joint,
    banded,
    between_sides,
    half_between,
    half_width,
    shared_half_width,
    ways_to_midline,
    without_unknown,
)
from breastrig.report.body_frame import BodyFrame, body_frame
from breastrig.report.calibration import measure_calibration
from breastrig.report.ptosis import STANDING, ptosis
from breastrig.report.stance import MODEL, Place, Stance, places
from breastrig.report.symmetry import MODEL_PART, symmetry
from breastrig.report.table import NOT_SEEN, Row, Value, with_vague
from breastrig.report.volume import METHOD as VOLUME_METHOD
from breastrig.report.volume import breast_outline, breast_volume, seen_share
from breastrig.rig.model import DrawnShape, Length

STRAIGHT, ALONG_SKIN = "straight", "along the skin"
SEEN = 0.5  # share of a breast's skin that a scan shows, below which what the model has there is no measure of it
SPACING = 0.002  # m between points of a line to which a distance is taken
OUTLINE = "breast base outline (model)"
BORDER = "areola's border (colour)"
CHORD = "distance in space"
ACROSS = (
    "at right angles to the fitted model's median plane, from the inner to the outer end of its breast base outline"
)
TAPE = "shortest way on the fitted model's skin"


def measures(stance: Stance) -> tuple[Row, ...]:
    """All rows that the rig's landmarks and drawings allow; without numbers of a breast that the scan does not show."""
    table = _Table(stance)
    rows = [row for part in PARTS if stance.rig.has_landmarks(part.needs) for row in part.rows(table)]
    unseen = {side: seen for side in SIDES if (seen := seen_share(stance, side)) is not None and seen < SEEN}
    return tuple(with_vague(without_unknown(_without_unseen(row, unseen))) for row in rows)


def _without_unseen(row: Row, unseen: Mapping[str, float]) -> Row:
    """The rows without values that rest only on the model, on a side that the scan does not show."""
    gone = [side for side in unseen if _is_models(row, side) or (row.value is None and _cell(row, side) is None)]
    if not gone:
        return row
    cells = tuple(SIDES[side] for side in gone) if row.value is None else ("value",)
    why = [f"the scan shows {100.0 * unseen[side]:.0f} % of the {SIDES[side]} breast: {NOT_SEEN}" for side in gone]
    return replace(
        row,
        left=None if "left" in cells else row.left,
        right=None if "right" in cells else row.right,
        value=None if "value" in cells else row.value,
        landmarks=tuple(name for name in row.landmarks if not any(_is_of_model(name, side) for side in gone)),
        method="; ".join([row.method, *why]),
        paths={cell: path for cell, path in row.paths.items() if row.value is None and cell not in cells},
        not_seen=cells,
    )


def _cell(row: Row, side: str) -> Value | None:
    found: Value | None = getattr(row, SIDES[side])
    return found


def _is_models(row: Row, side: str) -> bool:
    """Whether a row uses a part that is only the model's on this side; outlines are, on both."""
    return any(name in (OUTLINE, MODEL_PART) or _is_of_model(name, side) for name in row.landmarks)


def _is_of_model(named: str, side: str) -> bool:
    """Whether a landmark with its source is the model's, on this side."""
    return named.endswith(f"_{side} ({MODEL})")


class _Table:
    """The measures of one stance."""

    def __init__(self, stance: Stance) -> None:
        self.stance = stance
        self.places = places(stance)
        self.frame: BodyFrame = body_frame(stance.rig, stance.vertices)
        self.between = self._between_sides()
        self._skin = Geodesics(stance.vertices, stance.rig.faces)
        self._asked = [each for each in stance.rig.lengths if stance.rig.has_landmarks((each.start, each.end))]

    def lengths(self) -> Iterator[Row]:
        """The lengths that the rig defines."""
        self._look_for_all_ways()
        for asked in self._asked:
            ends = {side: self._ends(asked, side) for side in SIDES}
            if ends["L"] == ends["R"]:
                yield from self._one(asked.name, asked.label, ends["L"])
            else:
                yield from self._sided(asked.name, asked.label, ends, partial(self._between, ends))

    def between_nipples(self) -> Iterator[Row]:
        """The distance from each nipple to the midline, where the rig draws one, and between both."""
        nipples = {side: [self.places[f"nipple_{side}"]] for side in SIDES}
        midline = self.stance.shape("midline")
        if midline is not None:
            yield from self._sided(
                "nipple_midline",
                "Nipple to midline",
                nipples,
                lambda side: self._to_midline(nipples[side][0], midline),
                ("at right angles to the fitted model's median plane", f"{TAPE} to its midline"),
            )
        yield from self._one("nipple_nipple", "Nipple to nipple", [*nipples["L"], *nipples["R"]])

    def base_widths(self) -> Iterator[Row]:
        """The base widths; none for a rig without outlines of the breasts, and none lying."""
        widths = [self._base_width(breast_outline(self.stance.rig, side)) for side in SIDES]
        if all(width is not None for width in widths) and self.stance.name == STANDING:
            (left, across_left), (right, across_right) = (width for width in widths if width is not None)
            paths = {"left": across_left, "right": across_right}
            known = measure_calibration(self.stance.rig)
            between = None if known is None else half_between(left, right, known.sides.base_width)
            yield Row(
                "base_width", "Base width", STRAIGHT, "mm", left, right, None, (OUTLINE,), ACROSS, paths,
                between=between,
            )  # fmt: skip

    def _look_for_all_ways(self) -> None:
        """Computes all ways on the skin together, in a third of the time, and caches them."""
        nipples = [self.places[name] for side in SIDES if (name := f"nipple_{side}") in self.places]
        if nipples and self.stance.shape("midline") is not None:
            self._skin.look_from(joined([self._on_skin(place.point) for place in nipples]), np.inf)
        pairs = [self._ends(asked, side) for asked in self._asked for side in SIDES] + (
            [nipples] if len(nipples) == 2 else []
        )
        ways = [(a.point, b.point) for a, b in pairs]
        if ways:
            starts, goals = (joined([self._on_skin(point) for point in ends]) for ends in zip(*ways, strict=True))
            self._skin.paths(starts, goals)

    def _ends(self, asked: Length, side: str) -> list[Place]:
        """The two ends of a length, on this side where they have sides."""
        return [self.places[end if end in self.places else f"{end}_{side}"] for end in (asked.start, asked.end)]

    def _one(self, name: str, label: str, ends: Sequence[Place]) -> Iterator[Row]:
        """Two rows of a length without sides, straight and along the skin."""
        half, landmarks = self._half(ends), _named(ends)
        for kind, line, method in zip((STRAIGHT, ALONG_SKIN), self._apart(ends), (CHORD, TAPE), strict=True):
            value = _mm(length(line), half)
            yield Row(name, label, kind, "mm", None, None, value, landmarks, method, {"value": line})

    def _sided(
        self,
        name: str,
        label: str,
        ends: Mapping[str, Sequence[Place]],
        measured: Callable[[str], tuple[Array, Array]],
        methods: tuple[str, str] = (CHORD, TAPE),
    ) -> Iterator[Row]:
        """Two rows, straight and along the skin."""
        halves = {side: self._half(ends[side]) for side in SIDES}
        between = self._half_between(ends["L"], ends["R"])
        lines = {side: measured(side) for side in SIDES}
        landmarks = _named([place for side in SIDES for place in ends[side]])
        shared = self._in_all_stances([place for side in SIDES for place in ends[side]])
        for index, kind in enumerate((STRAIGHT, ALONG_SKIN)):
            left, right = (_mm(length(lines[side][index]), halves[side]) for side in SIDES)
            paths = {"left": lines["L"][index], "right": lines["R"][index]}
            yield Row(
                name, label, kind, "mm", left, right, None, landmarks, methods[index], paths,
                between=between, stances=shared,
            )  # fmt: skip

    def _in_all_stances(self, ends: Sequence[Place]) -> float:
        """Correlation of two fits' errors of lengths between two places of the model on either side."""
        known = measure_calibration(self.stance.rig)
        is_models = len(ends) == 2 * len(SIDES) and all(place.source == MODEL for place in ends)
        return known.stances.lengths if known is not None and is_models else 0.0

    def _half(self, ends: Sequence[Place]) -> float | None:
        """Half of the band (m) of a length between two places, or of the distance of one to the midline."""
        if len(ends) == 2 or self.stance.joint is not None:
            return shared_half_width(self._ways(ends), self.stance.joint)
        return half_width([place.radius for place in ends])

    def _half_between(self, left: Sequence[Place], right: Sequence[Place]) -> float | None:
        """Half of the band (mm) of the difference of two lengths or distances to the midline; None if they share
        nothing."""
        if self.stance.joint is None and not len(left) == len(right) == 2:
            return None
        ways = [*self._ways(left), *((place, -way) for place, way in self._ways(right))]
        half = shared_half_width(ways, self.between)
        return None if half is None else 1e3 * half

    def _between_sides(self) -> Joint | None:
        """The joint covariance that differences of left and right take."""
        known, joint = measure_calibration(self.stance.rig), self.stance.joint
        if known is None or joint is None:
            return joint
        return between_sides(joint, self.frame, known.sides.apart.get(self.stance.name, 1.0))

    def _ways(self, ends: Sequence[Place]) -> list[tuple[Place, Array]]:
        """Gradients (3,) of the length between two places by each, or of the distance of one to the midline."""
        if len(ends) == 1:
            return ways_to_midline(ends[0], self.frame, self.places)
        (a, b) = ends
        way = (b.point - a.point) / max(float(np.linalg.norm(b.point - a.point)), 1e-9)
        return [(a, -way), (b, way)]

    def _between(self, ends: Mapping[str, Sequence[Place]], side: str) -> tuple[Array, Array]:
        return self._apart(ends[side])

    def _apart(self, ends: Sequence[Place]) -> tuple[Array, Array]:
        """The lines between two places, (M, 3) m each: straight and along the skin."""
        a, b = (place.point for place in ends)
        return np.stack([a, b]), self._skin.path(self._on_skin(a), self._on_skin(b))

    def _to_midline(self, nipple: Place, midline: DrawnShape) -> tuple[Array, Array]:
        rig, vertices = self.stance.rig, self.stance.vertices
        start = self._on_skin(nipple.point)
        line = resampled(midline.points.positions(vertices, rig.faces), SPACING, midline.closed)
        on = self.stance.on_model(line)
        far = self._skin.distances(int(start.faces[0]), start.barycentric[0])
        nearest = int(on.positions(far[:, None], rig.faces)[:, 0].argmin())
        goal = on[[nearest]]
        return np.stack([nipple.point, self.frame.on_plane(nipple.point)]), self._skin.path(start, goal)

    def _base_width(self, outline: DrawnShape | None) -> tuple[Value, Array] | None:
        """Across from the outline's inner to its outer end, and the (2, 3) m line: callipers are held upright in front
        of the chest, so depth does not count."""
        if outline is None:
            return None
        line = resampled(outline.points.positions(self.stance.vertices, self.stance.rig.faces), SPACING, closed=True)
        lateral = self.frame.lateral(line)
        first, second = line[lateral.argmin()], line[lateral.argmax()]
        known = measure_calibration(self.stance.rig)
        more = 0.0 if known is None or self.stance.radii is None else known.outline(self.stance.name).outwards
        radius = half_width([self.stance.radius_at(end[None]) for end in (first, second)])
        start = first - more * self.frame.axes[:, 0]
        width = float(np.ptp(lateral)) + 2.0 * more
        across = np.stack([start, start + width * self.frame.axes[:, 0]])
        return _mm(width, None if known is None or radius is None else known.base_width.of(radius)), across

    def _on_skin(self, point: Array) -> SurfacePoints:
        return self.stance.on_model(point[None])


def _areolae(stance: Stance) -> Iterator[Row]:
    """The areolae's diameters, from the border that the scan's colours show; none where there is no texture."""
    found = {side: stance.areolae.get(side) for side in SIDES}
    seen = {side: areola for side, areola in found.items() if areola is not None}
    if not seen:
        return
    values = {side: _mm(areola.diameter, areola.half) for side, areola in seen.items()}
    unseen = [f"the {name} one is not seen" for side, name in SIDES.items() if side not in seen]
    method = "; ".join(["diameter of the circle of its area, by the border of its colour on the scan", *unseen])
    paths = {name: np.concatenate([seen[side].rim, seen[side].rim[:1]]) for side, name in SIDES.items() if side in seen}
    left, right = values.get("L"), values.get("R")
    yield Row("areola_diameter", "Areola diameter", ALONG_SKIN, "mm", left, right, None, (BORDER,), method, paths)


def _volumes(stance: Stance) -> Iterator[Row]:
    left, right = (breast_volume(stance, side) for side in SIDES)
    if left is None or right is None:
        return
    numbers = [Value(*(1e6 * number for number in (v.value, v.low, v.high))) for v in (left, right)]
    seen = f"the scan shows {100.0 * left.seen:.0f} % of the left breast and {100.0 * right.seen:.0f} % of the right"
    method = f"{VOLUME_METHOD}; {seen}"
    paths = {name: _outline(stance, side) for side, name in SIDES.items()}
    known = measure_calibration(stance.rig)
    between = None if known is None else half_between(numbers[0], numbers[1], known.sides.volume)
    yield Row(
        "volume", "Volume", "volume", "ml", numbers[0], numbers[1], None, (OUTLINE,), method, paths, between=between
    )


def _outline(stance: Stance, side: str) -> Array:
    """(M, 3) m, its first point again at the end."""
    shape = breast_outline(stance.rig, side)
    assert shape is not None  # it has a volume
    line = shape.points.positions(stance.vertices, stance.rig.faces)
    return np.concatenate([line, line[:1]])


def _mm(metres: float, half: float | None) -> Value:
    return banded(1e3 * metres, None if half is None else 1e3 * half)


def _named(found: Sequence[Place]) -> tuple[str, ...]:
    """Each landmark once, with its source."""
    return tuple(dict.fromkeys(map(str, found)))


@dataclass(frozen=True)
class Part:
    """Rows of the table, with the landmarks that a rig must have for them."""

    needs: tuple[str, ...]  # without sides where there are two
    rows: Callable[[_Table], Iterable[Row]]


PARTS = (
    Part((), _Table.lengths),
    Part(("nipple",), _Table.between_nipples),
    Part(("nipple",), _Table.base_widths),
    Part(("nipple", "inframammary_fold"), lambda table: ptosis(table.stance, table.frame, table.places, table.between)),
    Part(("nipple",), lambda table: _areolae(table.stance)),
    Part(("nipple",), lambda table: _volumes(table.stance)),
    Part(
        ("nipple",),
        lambda table: sorted(
            symmetry(table.stance, table.frame, table.places, table.between), key=lambda row: row.measure
        ),
    ),
)
