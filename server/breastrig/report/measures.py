"""The measures of a breast: each straight, as callipers give it, and along the skin, as a tape does.

Definitions: notch, midclavicle and fold to nipple, nipple to midline, nipple to nipple and base width as clinics take
them (Henseler 2023, who gives them for 100 women); the symmetry ratios are in symmetry.py, the volume in volume.py.
Landmarks are taken where they were picked, unless the pick was doubted, else from the fitted model; every row says
which.

Lengths along the skin run on the fitted model: a scan has holes under and beside the breast, just where a tape runs.
A pick is first put on it.  The tape is exact on the mesh (geometry/geodesic.py) and laid without stretching the skin.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np

from breastrig.core.arrays import Array
from breastrig.geometry.curves import resampled
from breastrig.geometry.geodesic import Geodesics, length
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.report.body_frame import BodyFrame, body_frame
from breastrig.report.stance import Place, Stance, places
from breastrig.report.symmetry import symmetry
from breastrig.report.table import Row, Value
from breastrig.report.volume import METHOD as VOLUME_METHOD
from breastrig.report.volume import breast_outline, breast_volume
from breastrig.rig.model import DrawnShape

SIDES = ("L", "R")
STRAIGHT, ALONG_SKIN = "straight", "along the skin"
SPACING = 0.002  # m between points of a line to which a distance is taken
OUTLINE = "breast base outline (model)"
END = 0.003  # m; the sides of the outline run upright, so its very last point wanders up and down by centimetres
CHORD = "distance in space"
TAPE = "shortest way on the fitted model's skin"


def measures(stance: Stance) -> tuple[Row, ...]:
    """All rows that the rig's landmarks and drawings allow."""
    table = _Table(stance)
    sorted_by_name = sorted(symmetry(stance, table.frame, table.places), key=lambda row: row.measure)
    return (*table.lengths(), *_volumes(stance), *sorted_by_name)


class _Table:
    """One stance ready to be measured."""

    def __init__(self, stance: Stance) -> None:
        self.stance = stance
        self.places = places(stance)
        self.frame: BodyFrame = body_frame(stance.rig, stance.vertices)
        self._skin = Geodesics(stance.vertices, stance.rig.faces)

    def lengths(self) -> Iterator[Row]:
        """The rows in mm."""
        for name, label, first, second in (
            ("notch_nipple", "Notch to nipple", "suprasternal_notch", "nipple"),
            ("midclavicle_nipple", "Midclavicle to nipple", "midclavicle", "nipple"),
            ("nipple_fold", "Nipple to fold", "nipple", "inframammary_fold"),
        ):
            ends = {side: [self._place(part, side) for part in (first, second)] for side in SIDES}
            yield from self._sided(name, label, ends, partial(self._between, ends))
        nipples = {side: [self._place("nipple", side)] for side in SIDES}
        midline = self.stance.shape("midline")
        if midline is not None:
            yield from self._sided(
                "nipple_midline",
                "Nipple to midline",
                nipples,
                lambda side: self._to_midline(nipples[side][0], midline),
                ("at right angles to the fitted model's median plane", f"{TAPE} to its midline"),
            )
        both = [self._place("nipple", side) for side in SIDES]
        if all(place is not None for place in both):
            for kind, number, method in zip((STRAIGHT, ALONG_SKIN), self._apart(both), (CHORD, TAPE), strict=True):
                yield Row(
                    "nipple_nipple", "Nipple to nipple", kind, "mm", None, None, _mm(number), _named(both), method
                )
        outlines = {side: breast_outline(self.stance.rig, side) for side in SIDES}
        if all(outline is not None for outline in outlines.values()):
            said = "between the medial and lateral end of the model's breast base outline (middle of the last 3 mm)"
            yield from self._sided(
                "base_width",
                "Base width",
                {side: [] for side in SIDES},
                lambda side: self._across(outlines[side]),
                (f"{CHORD} {said}", f"{TAPE} {said}"),
                (OUTLINE,),
            )

    def _place(self, part: str, side: str) -> Place | None:
        return self.places.get(part) or self.places.get(f"{part}_{side}")

    def _sided(
        self,
        name: str,
        label: str,
        ends: dict[str, list[Place | None]],
        measured: Callable[[str], tuple[float, float]],
        methods: tuple[str, str] = (CHORD, TAPE),
        further: tuple[str, ...] = (),
    ) -> Iterator[Row]:
        """Two rows, straight and along the skin; none where a landmark is missing on the rig."""
        if any(place is None for side in SIDES for place in ends[side]):
            return
        numbers = {side: measured(side) for side in SIDES}
        landmarks = _named([place for side in SIDES for place in ends[side]]) + further
        for index, kind in enumerate((STRAIGHT, ALONG_SKIN)):
            left, right = (_mm(numbers[side][index]) for side in SIDES)
            yield Row(name, label, kind, "mm", left, right, None, landmarks, methods[index])

    def _between(self, ends: dict[str, list[Place | None]], side: str) -> tuple[float, float]:
        return self._apart(ends[side])

    def _apart(self, ends: Sequence[Place | None]) -> tuple[float, float]:
        """m: straight and along the skin."""
        a, b = (place.point for place in ends if place is not None)
        return float(np.linalg.norm(a - b)), self._tape(self._on_skin(a), self._on_skin(b))

    def _to_midline(self, nipple: Place | None, midline: DrawnShape) -> tuple[float, float]:
        assert nipple is not None
        rig, vertices = self.stance.rig, self.stance.vertices
        start = self._on_skin(nipple.point)
        line = resampled(midline.points.positions(vertices, rig.faces), SPACING, midline.closed)
        on = self.stance.on_model(line)
        far = self._skin.distances(int(start.faces[0]), start.barycentric[0])
        nearest = int(on.positions(far[:, None], rig.faces)[:, 0].argmin())
        goal = SurfacePoints(on.faces[[nearest]], on.barycentric[[nearest]])
        return abs(float(self.frame.lateral(nipple.point))), self._tape(start, goal)

    def _across(self, outline: DrawnShape | None) -> tuple[float, float]:
        assert outline is not None
        line = resampled(outline.points.positions(self.stance.vertices, self.stance.rig.faces), SPACING, closed=True)
        lateral = self.frame.lateral(line)
        a, b = (_middle_of_end(line, sign * lateral) for sign in (1.0, -1.0))
        return float(np.linalg.norm(a - b)), self._tape(self._on_skin(a), self._on_skin(b))

    def _on_skin(self, point: Array) -> SurfacePoints:
        return self.stance.on_model(point[None])

    def _tape(self, a: SurfacePoints, b: SurfacePoints) -> float:
        return length(self._skin.path(a, b))


def _middle_of_end(line: Array, reach: Array) -> Array:
    """(3,) m: the point in the middle of where the (N, 3) line reaches as far as it goes, give or take END."""
    farthest = line[reach > reach.max() - END]
    return np.asarray(farthest[np.linalg.norm(farthest - farthest.mean(axis=0), axis=1).argmin()])


def _volumes(stance: Stance) -> Iterator[Row]:
    left, right = (breast_volume(stance, side) for side in SIDES)
    if left is None or right is None:
        return
    numbers = [Value(*(1e6 * number for number in (v.value, v.low, v.high))) for v in (left, right)]
    seen = f"the scan shows {100.0 * left.seen:.0f} % of the left breast and {100.0 * right.seen:.0f} % of the right"
    method = f"{VOLUME_METHOD}; {seen}"
    yield Row("volume", "Volume", "volume", "ml", numbers[0], numbers[1], None, (OUTLINE,), method)


def _mm(metres: float) -> Value:
    return Value(1e3 * metres)


def _named(found: Sequence[Place | None]) -> tuple[str, ...]:
    """Each landmark once, with its source."""
    return tuple(dict.fromkeys(str(place) for place in found if place is not None))
