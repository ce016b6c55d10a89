"""Finds the lines drawn on the skin of a coloured scan.

Steps: pictures of the skin, ridges in each, chains of ridge points, pieces with the colour of ink, strokes joined of
them, and the kind of each stroke. One second for a texture of 2048 by 2048.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from breastrig.colour.ink import limits
from breastrig.colour.ink.kinds import Kind, sorted_out
from breastrig.colour.ink.pieces import Ink, measured
from breastrig.colour.ink.ridges import DENSITY, ridge_points
from breastrig.colour.ink.strokes import Stroke, strokes
from breastrig.colour.skin_texture import SkinTexture, skin_texture
from breastrig.core.arrays import Array
from breastrig.core.errors import BadScan
from breastrig.geometry.polyline import Polyline
from breastrig.scan.piece import COLOURLESS
from breastrig.scan.scan import Scan


@dataclass(frozen=True)
class Marker:
    name: str
    color: str  # "#rrggbb", how it is shown
    light: tuple[float, float, float]  # linear, of dry ink on paper


MARKERS = (
    Marker("violet", "#5b2a86", (0.07, 0.02, 0.18)),
    Marker("black", "#1c1c1e", (0.012, 0.012, 0.013)),
    Marker("blue", "#1f49a5", (0.012, 0.05, 0.31)),
    Marker("green", "#13694a", (0.006, 0.12, 0.06)),
    Marker("red", "#b3202a", (0.42, 0.012, 0.02)),
)


DOUBT = 0.012  # likenesses this close say nothing; a faint stroke is then of the marker that drew most
EXPOSURES = np.geomspace(0.25, 1.0, 9)  # light that white would send back in the picture; 1 is its brightest


def markers_of(added: Array, lengths: Array, skin: Array) -> list[Marker]:
    """The marker of each of N strokes that add densities (N, 3) over (N,) m to lit skin of densities (3,), R, G, B.

    The picture's exposure is unknown; the one under which the strokes look most like markers is taken, the same for
    all.
    """
    if not len(added):
        return []
    missing = 1.0 - np.exp(-added)
    missing /= np.maximum(np.linalg.norm(missing, axis=1, keepdims=True), 1e-9)
    light = np.array([marker.light for marker in MARKERS])
    inks = 1.0 - EXPOSURES[:, None, None] * light / np.exp(-skin)  # (E, 5, 3)
    inks /= np.linalg.norm(inks, axis=2, keepdims=True)
    likeness = np.einsum("eki,ni->enk", inks, missing)
    exposure = int(np.argmax(likeness.max(axis=2) @ lengths))
    looks = likeness[exposure]
    used = np.bincount(looks.argmax(axis=1), lengths, len(MARKERS))
    possible = looks >= looks.max(axis=1, keepdims=True) - DOUBT
    return [MARKERS[number] for number in np.where(possible, used, -1.0).argmax(axis=1)]


BLACK = "black"
LIT = 20.0  # percentile of the densities of the scan's triangles; skin is seen well lit there


@dataclass(frozen=True, eq=False)
class InkLine:
    """One stroke of a pen on the skin."""

    line: Polyline  # in the scan's frame, m
    kind: Kind
    marker: Marker
    length: float  # m of ink, without gaps


def fine_texture(scan: Scan, image: NDArray[np.uint8] | None = None) -> SkinTexture:
    """The pictures of a scan whose colours are fine enough for a pen's line; `image` is as in `skin_texture`.

    Raises BadScan, with one sentence, for all others.
    """
    if scan.colour_kind == "none":
        raise BadScan(COLOURLESS)
    texture = skin_texture(scan, limits.TEXEL, image)
    if not np.isfinite(texture.source_texel):
        raise BadScan("The texture of this scan does not lie on its triangles; export it again.")
    if texture.source_texel > limits.FINE_ENOUGH:
        how = "with a finer texture" if scan.colour_kind == "texture" else "with its texture or with more triangles"
        raise BadScan(
            f"The colours of this scan are {1e3 * texture.source_texel:.1f} mm apart, too coarse for lines of a pen "
            f"(at most {1e3 * limits.FINE_ENOUGH:.1f} mm); export it {how}."
        )
    return texture


def find_ink(scan: Scan, factor: float = 1.0, image: NDArray[np.uint8] | None = None) -> tuple[InkLine, ...]:
    """All strokes of ink on a coloured scan, longest first; perhaps none.

    `factor` makes all thresholds of density larger or smaller, for evaluations; `image` is as in `skin_texture`.

    Raises BadScan, with one sentence, for a scan without colour or with colours too coarse for a pen's line.
    """
    texture = fine_texture(scan, image)
    found = [ridge_points(picture, texture.owner == number) for number, picture in enumerate(texture.pictures)]
    if not found:
        return ()
    lit = np.percentile(DENSITY[texture.face_colours], LIT, axis=0).astype(np.float64)
    lines, on_skin = measured(texture, found), scan.vertices[np.unique(scan.faces)]
    sure = factor * limits.SURE
    if not sorted_out(strokes(lines.pieces(sure), on_skin, sure)):
        return ()
    drawn = sorted_out(strokes(lines.pieces(factor), on_skin, factor))
    markers = _markers(drawn, lit)
    if _black(drawn, markers) >= limits.SURE_BLACK:
        drawn = sorted_out(strokes(lines.pieces(factor, has_black=True), on_skin, factor, has_black=True))
        markers = _markers(drawn, lit)
    return tuple(
        InkLine(
            Polyline(f"ink_{number}", stroke.closed, marker.color, stroke.places, stroke.bridged),
            kind,
            marker,
            stroke.length,
        )
        for number, ((stroke, kind), marker) in enumerate(zip(drawn, markers, strict=True), 1)
    )


def _markers(drawn: list[tuple[Stroke, Kind]], lit: Array) -> list[Marker]:
    added = np.array([stroke.added for stroke, _ in drawn]).reshape(-1, 3)
    return markers_of(added, np.array([stroke.length for stroke, _ in drawn]), lit)


def _black(drawn: list[tuple[Stroke, Kind]], markers: list[Marker]) -> float:
    """Length (m) of lines that are black by their densities (worn ones), or most similar to black ink (full ones)."""
    return sum(
        stroke.length
        for (stroke, kind), marker in zip(drawn, markers, strict=True)
        if (stroke.ink is Ink.BLACK or marker.name == BLACK) and not kind.is_mark
    )
