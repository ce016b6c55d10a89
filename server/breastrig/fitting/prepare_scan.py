"""Prepares a scan for a fit: cleans it, cuts floors, walls, other people's hands and the table under a patient away.

Upload, proposals, fits and evaluations all use it, so that they look at the same skin. The scan's directions found at
the upload are passed on with the scan and not searched again.

A process that serves one scan alone keeps what was cleaned and indexed for its next tasks: it does so when it is called
by `keeping`; elsewhere nothing is kept.  What is kept serves a scan that has the very same vertices and triangles,
compared number by number, so that a result never depends on what was kept.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.stances import STANDING
from breastrig.correspondence.target import ScanTarget
from breastrig.geometry.normals import face_areas
from breastrig.geometry.plane import Plane
from breastrig.scan.around.background import cut_background, without_background
from breastrig.scan.around.other_pieces import Piece, without_other_pieces
from breastrig.scan.around.table import Table, found_table
from breastrig.scan.clean import MIN_TRIANGLES, Surface, clean, compact, large_pieces
from breastrig.scan.orient import LABEL_MAP_FRAME, Frame, frame_of_image, propose_frame
from breastrig.scan.scan import Scan


@dataclass(frozen=True, eq=False)
class PreparedScan:
    """A prepared scan, the target of a fit."""

    surface: Surface  # in the scan's own frame, table included; floors, walls and other people's hands not
    target: ScanTarget  # without the table
    table_triangles: int  # how many were cut away as table
    known_frame: Frame | None = None
    cut_away: float = 0.0  # m², of floors, walls and what is none of the body
    beside: tuple[Piece, ...] = ()  # of these, what is no floor and no wall

    @cached_property
    def frame(self) -> Frame:
        """Front and stance as they are seen on the whole scan."""
        return self.known_frame or propose_frame(self.surface.vertices, self.surface.faces)

    @property
    def notes(self) -> tuple[str, ...]:
        """One sentence for each thing that was done."""
        if not self.table_triangles:
            return self.surface.notes
        return (*self.surface.notes, f"{self.table_triangles} triangles of the table under the patient were left out.")


def prepared(surface: Surface, stance: str, frame: Frame | None = None) -> PreparedScan:
    """The scan of a patient in this stance (auto | standing | supine | prone); `frame` when it is known already.

    A large plane close behind the body shows that the patient lies on a table, unless the stance is known to be
    standing: then it is a wall, and is cut away as all others are.
    """
    room = _without_background(surface, stance == STANDING, frame)
    body, plane = _without_table(surface.vertices, room)
    skin = room.faces if body is None else room.faces[body]
    own, beside = without_other_pieces(surface.vertices, skin, room.is_room)
    left, seen, cut_away = surface, room.frame, 0.0
    if beside or room.is_room:
        faces = np.delete(room.faces, np.flatnonzero(~own) if body is None else body[~own], axis=0)
        cut_away = float(face_areas(surface.vertices, surface.faces).sum() - face_areas(surface.vertices, faces).sum())
        note = _note(room.is_room, len(beside), cut_away)
        left = Surface(*compact(surface.vertices, faces), (*surface.notes, note))
        if frame is None and seen.table is None:
            seen = _seen_without(left, seen)
    if body is None:
        target, cut = ScanTarget(left.vertices, left.faces), 0
    else:
        target = ScanTarget(*compact(surface.vertices, skin[own]), table=plane)
        cut = len(room.faces) - len(body)
    return PreparedScan(left, target, cut, seen, cut_away, beside)


@dataclass(frozen=True, eq=False)
class _Room:
    """A scan of which floors and walls were cut away."""

    faces: Integers  # (F, 3) those that are left
    frame: Frame  # as they are seen
    table: Table | None  # what was found for frame.table on the way

    @property
    def is_room(self) -> bool:
        """Whether there were any."""
        return bool(self.frame.background)


def _without_background(surface: Surface, stands: bool, known: Frame | None) -> _Room:
    vertices, faces = surface.vertices, surface.faces
    if known is None:
        found = without_background(vertices, faces, stands)
        frame, table = found.frame, found.table
    else:
        frame, table = known, None
        if stands and known.table is not None:
            frame = replace(known, background=(*known.background, known.table))
        found = cut_background(vertices, faces, frame)
    return _Room(found.faces, replace(frame, table=None), None) if stands else _Room(found.faces, frame, table)


def _without_table(vertices: Array, room: _Room) -> tuple[Integers | None, Plane | None]:
    """Indices of the room's triangles that are not the table, and its plane; None where there is no table."""
    if room.frame.table is None:
        return None, None
    table = room.table or found_table(vertices, room.faces, *room.frame.table)
    body = np.flatnonzero(~table.triangles)
    if len(body) == len(room.faces) or len(body) < MIN_TRIANGLES:
        return None, None
    return body[large_pieces(vertices, room.faces[body])[0]], table.plane  # without what curled up at its edge


def _seen_without(surface: Surface, before: Frame) -> Frame:
    """The frame of what is left, when that shows no table either."""
    seen = propose_frame(surface.vertices, surface.faces)
    return before if seen.table is not None else replace(seen, background=before.background)


def _note(is_room: bool, pieces: int, area: float) -> str:
    if is_room:
        return f"A floor or wall and what stood by it were cut away: {1e4 * area:,.0f} cm²."
    which = "A piece beside the body was" if pieces == 1 else f"{pieces} pieces beside the body were"
    return f"{which} cut away: {1e4 * area:,.0f} cm²."


@dataclass
class _Kept:
    """The cached data of the last scan."""

    keeps: bool = False
    read: tuple[Array, Integers] | None = None  # the scan's own vertices and triangles
    surface: Surface | None = None  # of these
    target: ScanTarget | None = None  # with all that was built on it


_kept = _Kept()


def keeping(function: Callable[..., Any], *given: Any) -> Any:
    """The function's result, in a process that from now on caches the data of one scan."""
    _kept.keeps = True
    return function(*given)


def prepared_scan(scan: Scan, stance: str, frame: Frame | None = None) -> PreparedScan:
    """The scan cleaned and prepared; `frame` when it is known already.  Raises BadScan with a sentence."""
    of_map = LABEL_MAP_FRAME if scan.from_label_map else None
    stated = frame_of_image(scan.stated_stance) if scan.from_image else of_map
    ready = prepared(_cleaned(scan), stance, frame or stated)
    if not _kept.keeps:
        return ready
    if _kept.target is None or not _same_target(_kept.target, ready.target):
        _kept.target = ready.target
    return replace(ready, target=_kept.target)


def _cleaned(scan: Scan) -> Surface:
    if not _kept.keeps:
        return clean(scan)
    read = (scan.vertices, scan.faces)
    before = _kept.read
    same = before is not None and all(np.array_equal(*both) for both in zip(before, read, strict=True))
    if _kept.surface is None or not same:
        _kept.surface, _kept.target = clean(scan), None
        _kept.read = read
    return _kept.surface


def _same_target(one: ScanTarget, other: ScanTarget) -> bool:
    return (
        _same_plane(one.table, other.table)
        and one.use_rays == other.use_rays
        and (one.vertices is other.vertices or np.array_equal(one.vertices, other.vertices))
        and (one.faces is other.faces or np.array_equal(one.faces, other.faces))
    )


def _same_plane(one: Plane | None, other: Plane | None) -> bool:
    if one is None or other is None:
        return one is other
    return np.array_equal(one.normal, other.normal) and one.height == other.height
