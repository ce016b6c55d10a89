"""A template in true size: planned lines with the skin around them, laid flat, and how far off they are there.

A piece is a breast, or what crosses the midline: a ribbon around each line and around the shortest ways that join them
to the nipple and the nipple to the notch.  Ribbons that close are slit.  The narrower they are, the truer; the widest
is taken on which every line is true enough.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans
from breastrig.core.errors import BadDrawing, BadInput
from breastrig.core.stances import SIDES, split_side
from breastrig.geometry.boundary import boundary_loops
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.fields.distance_field import DistanceFields
from breastrig.geometry.flatten import Flattened, flattened
from breastrig.geometry.geodesic import Geodesics
from breastrig.geometry.half_edges import HalfEdges
from breastrig.geometry.polyline import Polyline, arc_lengths, resampled
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.report.body_frame import body_frame
from breastrig.report.guides.skin import skin_around
from breastrig.report.pages.names import spoken
from breastrig.report.stance import Place, Stance, places

FILLED = 0.0015  # m², a hole of a ring: paper that covers an areola holds better, where the skin is flat enough
TRIED = ((0.010, FILLED), (0.006, FILLED), (0.006, 0.0), (0.004, 0.0))  # m of paper beside each line, holes filled
TRUE = 0.001  # m, a line that is less off on the paper is drawn solid
TOO_FAR = 0.005  # m, one that is farther off is left out
MIDLINE = 0.01  # m, by which a line may pass the midline and still be of one side
TOUCHING = 0.004  # m between two lines that need no way to each other
SPACING = 0.003  # m between points
NOTCH = "suprasternal_notch"


@dataclass(frozen=True, eq=False)
class Hole:
    """A landmark to look through."""

    place: Place
    at: Array  # (2,) m


@dataclass(frozen=True, eq=False)
class FlatLine:
    """M points of a line on the paper."""

    line: Polyline  # on the skin, with these points; a closed one has its first point at the end as well
    points: Array  # (M, 2) m
    off: Array  # (M,) m, the largest error of a point's distance, along the skin, from any hole
    stretch: float  # m, the largest error of a length along the line
    ends: Booleans  # (M - 1,) whether a slit is between a point and the next

    @property
    def error(self) -> float:
        """m, the larger of both."""
        return max(float(self.off.max()), self.stretch)


@dataclass(frozen=True, eq=False)
class Piece:
    """One piece of paper; places are (m) from its lower left corner, the head is up, seen from outside."""

    sides: tuple[str, ...]  # L, R or both, the patient's
    size: Array  # (2,) m
    outline: Array  # (N, 2) m, closed
    slits: tuple[Array, ...]  # (2, 2) m, the middles of edges that meet on the skin
    holes: tuple[Hole, ...]
    lines: tuple[FlatLine, ...]
    margin: float  # m of paper beside each line

    @property
    def error(self) -> float:
        """m, of the line that is most off."""
        return max(each.error for each in self.lines)

    @property
    def name(self) -> str:
        """Patient's left side."""
        return f"Patient's {SIDES[self.sides[0]]} side" if len(self.sides) == 1 else "Both sides"


def template(stance: Stance) -> tuple[tuple[Piece, ...], tuple[str, ...]]:
    """The pieces of a stance's lines, right side first, and why lines are on none, a sentence each.

    Raises BadDrawing where a line's name says another side than its place, or no line can be laid flat; BadInput for a
    rig without the landmarks.
    """
    groups = lines_by_side(stance)
    pieces, said = [], []
    for sides, lines in groups.items():
        if lines:
            try:
                piece, left_out = _without_the_farthest(_piece(stance, lines, sides))
            except BadDrawing as error:
                said.append(str(error))
                continue
            pieces.append(piece)
            said += left_out
    if not pieces:
        raise BadDrawing(" ".join(said))
    return tuple(pieces), tuple(said)


def lines_by_side(stance: Stance) -> dict[tuple[str, ...], list[Polyline]]:
    """The lines of the right side, of the left one, and those that cross the midline; raises as `template`."""
    groups: dict[tuple[str, ...], list[Polyline]] = {("R",): [], ("L",): [], ("R", "L"): []}
    for line in stance.lines:
        if len(line) > 1:
            groups[_sides(stance, line)].append(line)
    if not any(groups.values()):
        raise BadInput("Nothing is drawn on this scan; a template shows lines: draw the plan first.")
    missing = [name for name in (NOTCH, "nipple_L", "nipple_R") if name not in places(stance)]
    if missing:
        raise BadInput(f"The model has no landmark {missing[0]}, by which a template is laid on the skin.")
    return groups


def _sides(stance: Stance, line: Polyline) -> tuple[str, ...]:
    """The sides on which a line lies; BadDrawing where its name says another."""
    across = body_frame(stance.rig, stance.vertices).lateral(line.points)
    found = tuple(side for side, sign in (("R", -1.0), ("L", 1.0)) if (sign * across).max() > MIDLINE) or ("R", "L")
    _, said = split_side(line.name.partition(" ")[0])
    if said and said not in found:
        raise BadDrawing(
            f"{spoken(line.name)}: it lies on the patient's {SIDES[found[0]]} side; give it a name of that side, "
            "or check the scan's frame."
        )
    return found


def _piece(stance: Stance, lines: Sequence[Polyline], sides: tuple[str, ...]) -> Piece:
    ways = _ways(stance, lines, sides)
    skin = skin_around(stance, [*lines, *ways], TRIED[0][0])
    sheet: _Sheet | None = None
    for margin, filled in TRIED:
        try:
            sheet = _Sheet(stance, flattened(*skin.within(margin, filled)), lines, margin)
        except BadDrawing:  # its parts overlap; narrower ones may not
            continue
        if max(each.stretch for each in sheet.lines) <= TRUE:
            found = sheet.piece(sides)
            if found.error <= TRUE:
                return found
    if sheet is None:
        raise BadDrawing(
            f"The lines on the patient's {SIDES[sides[0]]} side overlap each other when they are laid flat; "
            "use the report's tape sheet, or plan fewer lines."
        )
    return sheet.piece(sides)


def _without_the_farthest(piece: Piece) -> tuple[Piece, list[str]]:
    """Without lines that are TOO_FAR off, and a sentence for each."""
    far = [each for each in piece.lines if each.error > TOO_FAR]
    if len(far) == len(piece.lines):
        raise BadDrawing(
            f"{spoken(far[0].line.name)}: the skin is too curved there to be laid flat (off by up to "
            f"{1e3 * far[0].error:.0f} mm); use the report's tape sheet."
        )
    said = [
        f"{spoken(each.line.name)} is left out: laid flat it is up to {1e3 * each.error:.0f} mm off; "
        "use the report's tape sheet for it."
        for each in far
    ]
    return replace(piece, lines=tuple(each for each in piece.lines if each not in far)), said


def _ways(stance: Stance, lines: Sequence[Polyline], sides: tuple[str, ...]) -> list[Polyline]:
    """The shortest ways along the model that join all lines and holes."""
    known, geodesics = places(stance), Geodesics(stance.vertices, stance.rig.faces)

    def way(a: Array, b: Array) -> Polyline:
        return unnamed(geodesics.path(stance.on_model(a[None]), stance.on_model(b[None])))

    ways = [way(known[f"nipple_{side}"].point, known[NOTCH].point) for side in sides]
    joined, left = (
        np.concatenate([each.points for each in ways]),
        [resampled(line.points, SPACING, line.closed) for line in lines],
    )
    while left:
        tree = cKDTree(joined)
        gaps = [np.asarray(tree.query(each)[0]) for each in left]
        nearest = int(np.argmin([gap.min() for gap in gaps]))
        points, gap = left.pop(nearest), gaps[nearest]
        if gap.min() > TOUCHING:
            end = points[gap.argmin()]
            ways.append(way(joined[np.linalg.norm(joined - end, axis=1).argmin()], end))
        joined = np.concatenate([joined, points])
    return ways


def unnamed(points: Array) -> Polyline:
    """An open line through (M, 3) m points that is not shown."""
    return Polyline("", False, "#000000", points, np.zeros(len(points), dtype=np.bool_))


class _Sheet:
    """Skin laid flat with the lines on it."""

    def __init__(self, stance: Stance, sheet: Flattened, lines: Sequence[Polyline], margin: float) -> None:
        self.stance, self.margin = stance, margin
        self.sheet = replace(sheet, flat=_head_up(stance, sheet))
        self.search = ClosestPointSearch(sheet.vertices, sheet.faces)
        self.lines = [self._line(line) for line in lines]

    def _line(self, line: Polyline) -> FlatLine:
        """The line with the errors of its lengths alone."""
        on = self.search.query(line.outline).on_mesh
        skin, flat = (on.positions(each, self.sheet.faces) for each in (self.sheet.vertices, self.sheet.lifted))
        steps, there = (np.linalg.norm(np.diff(each, axis=0), axis=1) for each in (skin, flat))
        ends = np.asarray(there > 2.0 * steps + TRUE)
        longer = np.concatenate([[0.0], np.cumsum(np.where(ends, 0.0, there - steps))])
        return FlatLine(line, flat[:, :2], np.zeros(len(flat)), float(np.ptp(longer)), ends)

    def piece(self, sides: tuple[str, ...]) -> Piece:
        """The piece of these sides, with all errors."""
        sheet, known = self.sheet, places(self.stance)
        marks = [known[name] for name in (*(f"nipple_{side}" for side in sides), NOTCH)]
        on = self.search.query(np.array([mark.point for mark in marks])).on_mesh
        holes = [Hole(mark, at[:2]) for mark, at in zip(marks, on.positions(sheet.lifted, sheet.faces), strict=True)]
        slits = tuple(sheet.flat[each] for each in sheet.slits)
        outline = sheet.flat[boundary_loops(sheet.faces)[0]]
        lines = tuple(self._with_distances(on))
        return Piece(sides, sheet.flat.max(axis=0), outline, slits, tuple(holes), lines, self.margin)

    def _with_distances(self, holes: SurfacePoints) -> list[FlatLine]:
        """The lines with the errors of their distances, along the skin, from the holes."""
        on = self.search.query(np.concatenate([each.line.outline for each in self.lines])).on_mesh
        off = np.zeros(len(on))
        for hole in range(len(holes)):
            there, here = (
                DistanceFields(HalfEdges(each, self.sheet.faces), holes[[hole]], np.full(1, np.inf)).at(0, on)
                for each in (self.sheet.lifted, self.sheet.vertices)
            )
            off = np.maximum(off, np.abs(there - here))
        parts = np.split(off, np.cumsum([len(each.points) for each in self.lines])[:-1])
        return [replace(each, off=part) for each, part in zip(self.lines, parts, strict=True)]


def _head_up(stance: Stance, sheet: Flattened) -> Array:
    """(W, 2) m: turned as the piece is seen from the front, from its lower left corner."""
    seen = sheet.vertices @ body_frame(stance.rig, stance.vertices).axes[:, :2]
    flat, seen = sheet.flat - sheet.flat.mean(axis=0), seen - seen.mean(axis=0)
    dots, crosses = (flat * seen).sum(), (flat[:, 0] * seen[:, 1] - flat[:, 1] * seen[:, 0]).sum()
    angle = np.arctan2(crosses, dots)
    turned = flat @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return np.asarray(turned - turned.min(axis=0))


def length_on_skin(each: FlatLine) -> float:
    """m along the skin."""
    return float(arc_lengths(each.line.outline)[-1])
