"""A guide to print in 3D: a shell on the skin around planned lines, with slots for a pen, a hole for the nipple and an
arrow to the notch, as Sci Rep 2021;11:2252 laid on 88 supine patients.

The skin around the lines is cut at level lines of distance fields, given a thickness and walls, and so is closed.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadDrawing, BadInput
from breastrig.core.stances import SIDES
from breastrig.geometry.boundary import boundary_loops, triangle_components
from breastrig.geometry.caps import walled
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.fields.level_sets import part_above
from breastrig.geometry.geodesic import Geodesics
from breastrig.geometry.half_edges import neighbours, split_flat
from breastrig.geometry.normals import face_areas, face_normals, unit_vectors, vertex_normals
from breastrig.geometry.polyline import Polyline, arc_lengths, interpolated, length, resampled
from breastrig.geometry.self_intersections import crossing_faces
from breastrig.report.body_frame import body_frame
from breastrig.report.guides.skin import PAPILLA, skin_around
from breastrig.report.guides.template import NOTCH, lines_by_side, unnamed
from breastrig.report.stance import Stance, places

THICK = 0.002  # m
MARGIN = 0.012  # m of shell beside each line
RIM = 0.004  # m that are cut off again: the triangles' border is ragged
SLOT = 0.001  # m, half the width of a slot: a pen's tip
CUT, BRIDGE = 0.018, 0.005  # m of a slot, and of shell between two slots
SMALL = 0.045  # m, the length of a closed line that is cut out as a whole
ISLAND = 3e-4  # m², the largest piece that may fall out: what is inside such a line
STEP = 0.0005  # m between points of a slot
REACH = 0.1  # m around the lines, within which what they enclose is filled
FINER = 2  # splits of the skin's triangles, to 0.6 mm
SPARSER = 5  # times fewer triangles in the end
CLEAR = 5e-5  # m between a level line and a vertex, so that no triangle is without area
SMOOTHING = 6  # rounds on the normals along which the shell is thick
TONGUE = 0.045  # m beyond the lines, towards the notch
LETTERS = {  # strokes (mm, right and towards the notch) without islands, that say the side
    "L": (((-2.5, 10.0), (-2.5, 0.0), (3.0, 0.0)),),
    "R": (((-2.5, 0.0), (-2.5, 10.0)), ((0.5, 10.0), (3.0, 9.0), (3.0, 6.5), (0.5, 5.0)), ((0.5, 3.0), (3.0, 0.0))),
}
ARROW = (((0.0, 0.0), (0.0, 14.0)), ((-4.0, 10.0), (0.0, 14.0)), ((4.0, 10.0), (0.0, 14.0)))
LETTER_AT, ARROW_AT, TIP = 0.006, 0.021, 0.035  # m from where the tongue begins


@dataclass(frozen=True, eq=False)
class Guide:
    """A closed shell in the patient's own frame: left, up, front; its inside lies on the skin."""

    side: str  # L or R
    vertices: Array  # (V, 3) m
    faces: Integers  # (F, 3) counter-clockwise from outside
    tip: Array  # (3,) m, of the arrow
    to_notch: float  # m along the skin from there


def guide(stance: Stance, side: str) -> Guide:
    """The guide of the lines on one side, "L" or "R".

    Raises BadInput where nothing is drawn there, BadDrawing where the skin is folded or slots would part the shell.
    """
    lines = lines_by_side(stance)[(side,)]
    if not lines:
        raise BadInput(f"No line is on the patient's {SIDES[side]} side alone; a guide shows the lines of one side.")
    known, tape = places(stance), Geodesics(stance.vertices, stance.rig.faces)
    nipple = known[f"nipple_{side}"].point
    way = tape.path(stance.on_model(nipple[None]), stance.on_model(known[NOTCH].point[None]))
    begins = _leaves(way, lines)
    stem = unnamed(_along(way, np.arange(0.0, begins + TONGUE, SLOT)))
    skin = skin_around(stance, [*lines, stem], REACH)
    vertices, coarse = skin.within(MARGIN + RIM, np.inf)
    normals = vertex_normals(vertices, coarse)
    mean = neighbours(coarse, len(vertices))
    for _ in range(SMOOTHING):
        normals = unit_vectors(normals + mean @ normals)
    if len(crossing_faces(*walled(vertices, vertices + THICK * normals, coarse))):
        raise BadDrawing("The skin is folded too narrowly for a shell there; take the supine scan, or other lines.")
    sheet, faces = np.concatenate([vertices, normals], axis=1), coarse
    for _ in range(FINER):
        sheet, faces, _ = split_flat(sheet, faces)
    pens = [*(_dashes(line) for line in lines), *_signs(ClosestPointSearch(vertices, coarse), way, begins, side)]
    levels = _levels(sheet[:, :3], faces, [*lines, stem], np.concatenate(pens), nipple)
    sheet, faces = _one_piece(*part_above(sheet, faces, levels, 0.0))
    closed, triangles = _sparse(*walled(sheet[:, :3], sheet[:, :3] + THICK * unit_vectors(sheet[:, 3:]), faces))
    frame = body_frame(stance.rig, stance.vertices)
    tip = (_along(way, np.array([begins + TIP]))[0] - frame.middle) @ frame.axes
    return Guide(side, (closed - frame.middle) @ frame.axes, triangles, tip, length(way) - begins - TIP)


def _along(way: Array, at: Array) -> Array:
    return interpolated(at, arc_lengths(way), way)


def _leaves(way: Array, lines: Sequence[Polyline]) -> float:
    """m along the way where it leaves the shell around the lines; earlier where the notch is near."""
    along = np.arange(0.0, length(way), STEP)
    tree = cKDTree(np.concatenate([resampled(line.points, STEP, line.closed) for line in lines]))
    inside = np.flatnonzero(np.asarray(tree.query(_along(way, along))[0]) < MARGIN)
    last = float(along[inside[-1]]) if len(inside) else 0.0
    return max(min(last, length(way) - TONGUE), 0.0)


def _dashes(line: Polyline) -> Array:
    """(M, 3) m: points of its slots."""
    points = resampled(line.points, STEP, line.closed)
    along = arc_lengths(points)
    if line.closed and along[-1] < SMALL:
        return points
    count = max(round(along[-1] / (CUT + BRIDGE)), 1)  # whole slots, each between two halves of a bridge
    place = np.mod(along * count / along[-1], 1.0)
    return np.asarray(points[np.abs(place - 0.5) < 0.5 * CUT / (CUT + BRIDGE)])


def _signs(search: ClosestPointSearch, way: Array, begins: float, side: str) -> list[Array]:
    """(M, 3) m points of the side's letter and of the arrow, on the skin."""
    found = []
    for strokes, start in ((LETTERS[side], LETTER_AT), (ARROW, ARROW_AT)):
        origin, ahead = _along(way, np.array([begins + start, begins + start + STEP]))
        up = unit_vectors((ahead - origin)[None])[0]
        on = search.query(origin[None])
        out = face_normals(search.vertices, search.triangles)[on.faces[0]]
        right = np.cross(up, out)
        for stroke in strokes:
            places = 1e-3 * resampled(np.column_stack([np.array(stroke), np.zeros(len(stroke))]), 1e3 * STEP, False)
            found.append(search.query(origin + places[:, :1] * right + places[:, 1:2] * up).points)
    return found


def _levels(places: Array, faces: Integers, lines: Sequence[Polyline], pens: Array, nipple: Array) -> Array:
    """(V,) m above zero where the shell stays, never next to it."""

    def away(points: Array) -> Array:
        return np.asarray(cKDTree(points).query(places)[0])

    beside = MARGIN - away(np.concatenate([resampled(line.points, STEP, line.closed) for line in lines]))
    rims = np.concatenate([resampled(places[loop], STEP, True) for loop in boundary_loops(faces)])
    kept = np.maximum(beside, away(rims) - MARGIN - RIM)  # beside a line, or enclosed
    level = np.min([kept, away(pens) - SLOT, away(nipple[None]) - PAPILLA], axis=0)
    return np.where(np.abs(level) < CLEAR, np.where(level < 0.0, -CLEAR, CLEAR), level)


def _one_piece(sheet: Array, faces: Integers) -> tuple[Array, Integers]:
    """The largest piece; BadDrawing where another one is too large to be what a small closed line cuts out."""
    _, part = triangle_components(faces, len(sheet))
    areas = np.bincount(part[faces[:, 0]], face_areas(sheet[:, :3], faces))
    largest = int(areas.argmax())
    if np.delete(areas, largest).max(initial=0.0) > ISLAND:
        raise BadDrawing("These lines would cut the guide into pieces; leave out lines that cross each other.")
    used, kept = np.unique(faces[part[faces[:, 0]] == largest], return_inverse=True)
    return sheet[used], kept.reshape(-1, 3)


def _sparse(vertices: Array, faces: Integers) -> tuple[Array, Integers]:
    """The surface with fewer triangles, a fiftieth of a millimetre off at most: flat ones need not be small."""
    import igl

    found = igl.qslim(np.asfortranarray(vertices), np.asfortranarray(faces.astype(np.int32)), len(faces) // SPARSER)
    return np.ascontiguousarray(found[0]), np.ascontiguousarray(found[1], dtype=np.int64)
