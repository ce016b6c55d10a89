"""template.pdf: pieces of a template over sheets of A4 in true size, as JSON that template.typ sets."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.identity import UNNAMED, Identity
from breastrig.core.stances import SIDES
from breastrig.drawings.line_error import drawn_error
from breastrig.languages.catalogue import ENGLISH
from breastrig.languages.translation import Typed
from breastrig.report.guides.template import TRUE, FlatLine, Piece, length_on_skin
from breastrig.report.pages.names import spoken
from breastrig.report.pages.printable import check_printable
from breastrig.report.pages.tape_sheet import off_by
from breastrig.report.pages.typeset import typeset

SHEETS = ((180.0, 245.0), (267.0, 158.0))  # mm of an A4 page that is drawn on, upright and lying
OVERLAP = 10.0  # mm that two sheets have in common
AROUND = 8.0  # mm around a piece, for names
SHIFT = 10.0  # mm between places that are tried for a piece on its sheets
PINS = 10.0  # mm between two places to prick through


def template_pdf(
    pieces: Sequence[Piece],
    position: str,
    identity: Identity = UNNAMED,
    said: Sequence[str] = (),
    language: str = ENGLISH,
) -> bytes:
    """The pages; `position` names the stance, `said` are sentences on the fit.  BadInput for a name without glyphs."""
    names = [("The name of a line", spoken(each.line.name)) for piece in pieces for each in piece.lines]
    check_printable([("The patient's code", identity.code), *names])
    content = template_content(pieces, position, identity, said)
    return bytes(typeset("guides", "template.typ", content, language))


def template_content(
    pieces: Sequence[Piece], position: str, identity: Identity, said: Sequence[str] = ()
) -> dict[str, Any]:
    """All data of the template; mm from the upper left corner of a piece's first sheet."""
    scanned = next((day for day in identity.scanned if day), "")
    made = identity.made
    return {
        "made": None if made is None else [made.year, made.month, made.day],
        "code": Typed(identity.code),
        "position": position,
        "scan": ["scan received" if identity.received else "scanned", scanned],
        "plan": [f"plan, version {identity.plan_version}" if identity.plan_version else "plan", identity.planned],
        "overlap": OVERLAP,
        "said": list(said),
        "pieces": [_piece(piece) for piece in pieces],
    }


def _piece(piece: Piece) -> dict[str, Any]:
    lying, corner, sheets = _tiled(piece)

    def on_paper(points: Array) -> list[list[float]]:
        """mm, downwards."""
        return _mm(np.round(_downwards(piece, points) + corner, 2))

    smoothed = piece.outline
    for _ in range(2):  # what is cut out need not follow the triangles
        smoothed = 0.5 * smoothed + 0.25 * (np.roll(smoothed, 1, axis=0) + np.roll(smoothed, -1, axis=0))
    return {
        "name": piece.name,
        "lying": bool(lying),
        "sheet": list(SHEETS[lying]),
        "sheets": sheets,
        "outline": on_paper(smoothed),
        "slits": [[chr(ord("A") + k % 26), on_paper(slit)] for k, slit in enumerate(piece.slits)],
        "holes": [[_hole_name(hole.place.name), *on_paper(hole.at)] for hole in piece.holes],
        "lines": [_line(each, on_paper) for each in piece.lines],
        "landmarks": [[_hole_name(h.place.name), h.place.source, off_by(h.place.radius)] for h in piece.holes],
        "margin": f"{1e3 * piece.margin:.0f} mm of paper beside each line, {len(piece.slits)} slits",
    }


def _tiled(piece: Piece) -> tuple[int, Array, list[list[int]]]:
    """Upright (0) or lying sheets (1), the piece's upper left corner (2,) mm, and (column, row) of each sheet.

    Of all ways the one with the fewest sheets and then the fewest points of lines at their borders.
    """
    outline = _downwards(piece, piece.outline)
    points = _downwards(piece, np.concatenate([each.points for each in piece.lines]))
    best: tuple[int, int] | None = None
    found: tuple[int, Array, list[list[int]]] | None = None
    for lying, sheet in enumerate(np.array(SHEETS)):
        room = sheet - OVERLAP
        for shift in np.stack(np.meshgrid(*(np.arange(AROUND, most, SHIFT) for most in room)), axis=-1).reshape(-1, 2):
            tiles = np.unique(((outline + shift - 0.5 * OVERLAP) // room).astype(np.int64), axis=0)
            at = (points + shift - 0.5 * OVERLAP) % room
            cut = int(((at < 0.5 * OVERLAP + AROUND) | (at > room - 0.5 * OVERLAP - AROUND)).any(axis=1).sum())
            if best is None or (len(tiles), cut) < best:
                best, found = (len(tiles), cut), (lying, shift, tiles[np.lexsort(tiles.T)].tolist())
    assert found is not None
    return found


def _downwards(piece: Piece, points: Array) -> Array:
    """(M, 2) mm from the upper left corner of the piece, for (..., 2) m."""
    mm = 1e3 * points.reshape(-1, 2)
    return np.stack([mm[:, 0], 1e3 * piece.size[1] - mm[:, 1]], axis=1)


def _mm(points: Array) -> list[list[float]]:
    return [[float(value) for value in point] for point in points]


def _line(each: FlatLine, on_paper: Any) -> dict[str, Any]:
    """Its strokes (solid, dashed, dotted), places to prick through, and its row of numbers."""
    unseen = np.concatenate([each.line.bridged, each.line.bridged[:1]]) if each.line.closed else each.line.bridged
    far = np.maximum(each.off, each.stretch) > TRUE
    looks = np.where(unseen[:-1] | unseen[1:], "dotted", np.where(far[:-1] | far[1:], "dashed", "solid"))
    strokes: list[tuple[str, list[int]]] = []
    for k, (first, second) in enumerate(pairwise(range(len(each.points)))):
        if each.ends[k]:
            continue
        if strokes and strokes[-1][0] == looks[k] and strokes[-1][1][-1] == first:
            strokes[-1][1].append(second)
        else:
            strokes.append((str(looks[k]), [first, second]))
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(each.line.outline, axis=0), axis=1))])
    pins = np.unique(np.searchsorted(along, np.arange(0.0, along[-1], 1e-3 * PINS)))
    middle = each.points[int(np.searchsorted(along, 0.5 * along[-1]))]
    known = drawn_error([each.line])
    return {
        "name": spoken(each.line.name),
        "color": each.line.color,
        "strokes": [[look, on_paper(each.points[rows])] for look, rows in strokes],
        "pins": on_paper(each.points[pins]),
        "label": on_paper(middle)[0],
        "row": [
            spoken(each.line.name),
            f"{1e3 * length_on_skin(each):.0f}",
            f"{1e3 * each.error:.1f}",
            "as drawn" if known is None else f"±{1e3 * known:.0f}",
        ],
    }


def _hole_name(name: str) -> str:
    side = name.rpartition("_")[2]
    return f"Nipple, {SIDES[side]}" if side in SIDES else "Notch"
