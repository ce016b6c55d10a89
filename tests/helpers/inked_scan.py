"""Skin with lines of a pen on it: a half cylinder with a texture in two charts, the seam through the lines.

Everything is painted by formula, on skin under uneven light, with grain, a mole, a scar and a hair, which are no ink.
Places are (s, t): mm along the arc and upwards.
"""

import io
import zipfile
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from PIL import Image
from scipy.spatial import cKDTree

SIZE, RADIUS = 240.0, 150.0  # mm: of the sheet along both ways, of the cylinder
SIDE = 512  # pixels
STEPS = 40  # triangles along each way are twice these
SKIN = (0.46, 0.25, 0.17)  # linear light
DARK_SKIN = (0.125, 0.062, 0.041)  # of the darkest people; ink that covers it is lighter in some channel
INKS = {
    "violet": (0.07, 0.03, 0.16),
    "black": (0.012, 0.012, 0.013),
    "blue": (0.015, 0.05, 0.3),
    "green": (0.01, 0.12, 0.06),
    "red": (0.4, 0.015, 0.02),
    "hint": (0.355, 0.191, 0.165),  # what vessels or hair may look like, somewhat above what counts as ink
    "worn": (0.313, 0.162, 0.103),  # black of which little is left on this skin
}
MATERIAL = b"newmtl skin\nmap_Kd texture.png\n"


@dataclass(frozen=True)
class Stroke:
    """One line of the pen."""

    name: str
    marker: str
    kind: str
    places: np.ndarray  # (M, 2) mm, half a millimetre apart
    drawn: np.ndarray  # (M,) false in the gaps of a dashed line
    closed: bool = False


def _line(name: str, marker: str, kind: str, corners: list[tuple[float, float]], **options: object) -> Stroke:
    corners_ = np.array(corners)
    at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners_, axis=0), axis=1))])
    length = np.arange(0.0, at[-1], 0.5)
    places = np.stack([np.interp(length, at, corners_[:, axis]) for axis in range(2)], axis=1)
    dashed = kind == "dashed"
    return Stroke(name, marker, kind, places, (length % 14.0 < 9.0) | (not dashed), **options)


def strokes(marker: str | None = None) -> tuple[Stroke, ...]:
    """All of the drawing; `marker` draws everything when it is given."""
    turn = np.linspace(0.0, 2.0 * np.pi, 90)
    circle = [(170.0 + 32.0 * np.cos(a), 150.0 + 32.0 * np.sin(a)) for a in turn]
    letter = [(30.0 + 5.5 * np.cos(a), 30.0 + 5.5 * np.sin(a)) for a in turn[:75]]
    return (
        _line("across", marker or "violet", "line", [(20, 70), (110, 62), (220, 75)]),
        _line("upwards", marker or "red", "dashed", [(70, 90), (78, 225)]),
        _line("round", marker or "black", "closed", circle, closed=True),
        _line("arm_1", marker or "green", "cross", [(92, 30), (108, 30)]),
        _line("arm_2", marker or "green", "cross", [(100, 22), (100, 38)]),
        _line("letter", marker or "blue", "writing", letter),
    )


def place(st: np.ndarray) -> np.ndarray:
    """(M, 3) m of (M, 2) mm on the sheet; outside is +Z in its middle."""
    angle = (st[:, 0] - SIZE / 2) / RADIUS
    return 1e-3 * np.stack([RADIUS * np.sin(angle), st[:, 1], RADIUS * np.cos(angle)], axis=1)


def _uv(st: np.ndarray, right: np.ndarray) -> np.ndarray:
    """(M, 2): the left half of the sheet in the lower half of the picture, the right half in the upper one, turned."""
    s, t = st.T / SIZE
    left = np.stack([0.01 + 0.98 * t, 0.01 + 0.96 * s], axis=1)
    other = np.stack([0.99 - 0.98 * t, 0.515 + 0.96 * (s - 0.5)], axis=1)
    return np.where(right[:, None], other, left)


@lru_cache(maxsize=1)
def _sheet() -> np.ndarray:
    """(SIDE * SIDE, 2) mm: where each of the picture's pixels lies."""
    column, row = np.meshgrid((np.arange(SIDE) + 0.5) / SIDE, 1 - (np.arange(SIDE) + 0.5) / SIDE)
    upper = row > 0.5
    s = np.where(upper, (row - 0.515) / 0.96 + 0.5, (row - 0.01) / 0.96) * SIZE
    t = np.where(upper, (0.99 - column) / 0.98, (column - 0.01) / 0.98) * SIZE
    return np.stack([s, t], axis=2).reshape(-1, 2)


@lru_cache(maxsize=1)
def _covered() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Of each stroke by name, whatever its marker: the pixels on which there is ink, and its share of them."""
    found = {}
    for stroke in strokes():
        distance = cKDTree(stroke.places[stroke.drawn]).query(_sheet(), distance_upper_bound=4.0)[0]
        share = np.clip(1.6 - distance, 0.0, 1.0)[:, None] * 0.9  # some 2 mm wide
        pixels = np.flatnonzero(share)
        found[stroke.name] = pixels, share[pixels]
    return found


def _picture(drawn: tuple[Stroke, ...], skin: tuple[float, float, float] = SKIN) -> np.ndarray:
    """(SIDE, SIDE, 3) sRGB."""
    rng = np.random.default_rng(4)
    st = _sheet()
    light = np.ones((len(st), 3)) * skin
    mottled = 1.0 + 0.06 * np.sin(st[:, :1] / 9.0) * np.cos(st[:, 1:] / 13.0)
    light *= mottled
    mole = np.linalg.norm(st - [40.0, 150.0], axis=1) < 2.0
    light[mole] = np.multiply(skin, (0.35, 0.24, 0.18))
    scar = (np.abs(st[:, 1] - 205.0) < 1.0) & (np.abs(st[:, 0] - 180.0) < 20.0)
    light[scar] *= (1.0, 0.85, 0.85)
    hair = np.abs(st[:, 0] - 130.0 - 4.0 * np.sin(st[:, 1] / 30.0)) < 0.2
    light[hair] *= 0.55
    for stroke in drawn:
        pixels, share = _covered()[stroke.name]
        light[pixels] = (1.0 - share) * light[pixels] + share * np.asarray(INKS[stroke.marker])
    lamp = 0.35 + 0.4 * np.exp(-((st - [90.0, 170.0]) ** 2).sum(axis=1) / 140.0**2)
    light *= lamp[:, None] * (1.0 + 0.03 * rng.normal(size=(len(st), 1)))
    value = np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 0.0) ** (1 / 2.4) - 0.055)
    return np.rint(255 * np.clip(value, 0, 1)).astype(np.uint8).reshape(SIDE, SIDE, 3)


def _mesh(steps: int = STEPS) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """((V, 2) mm, (F, 3) with outside normals, (F,) whether they are of the right half)."""
    grid = np.linspace(0.0, SIZE, 2 * steps + 1)
    s, t = (each.ravel() for each in np.meshgrid(grid, grid, indexing="ij"))
    n = len(grid)
    first = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate(
        [np.stack([first, first + n, first + 1], axis=1), np.stack([first + n, first + n + 1, first + 1], axis=1)]
    )
    return np.stack([s, t], axis=1), faces, s[faces].mean(axis=1) > SIZE / 2


@lru_cache(maxsize=1)
def _obj() -> str:
    """All of the scan but its picture."""
    st, faces, right = _mesh()
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in place(st)]
    for half in (False, True):
        lines += [f"vt {u:.6f} {v:.6f}" for u, v in _uv(st, np.full(len(st), half))]
    lines.append("mtllib scan.mtl\nusemtl skin")
    lines += [
        "f " + " ".join(f"{c + 1}/{c + 1 + len(st) * half}" for c in face)
        for face, half in zip(faces.tolist(), right.astype(int).tolist(), strict=True)
    ]
    return "\n".join(lines) + "\n"


@lru_cache(maxsize=4)
def inked_zip(marker: str | None = None, bare: bool = False, worn: bool = False, dark: bool = False) -> bytes:
    """The scan as a zip of OBJ, MTL and PNG, in metres; `bare` without ink, `worn`: little is left of one line."""
    first, *rest = strokes(marker)
    drawn = () if bare else (replace(first, marker="worn") if worn else first, *rest)
    picture = io.BytesIO()
    Image.fromarray(_picture(drawn, DARK_SKIN if dark else SKIN)).save(picture, "PNG")
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("scan.obj", _obj())
        archive.writestr("scan.mtl", MATERIAL)
        archive.writestr("texture.png", picture.getvalue(), zipfile.ZIP_STORED)
    return packed.getvalue()


def vertex_coloured(steps: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """((V, 3) m, (F, 3), (V, 3) colours) of the same scan without a texture."""
    st, faces, _ = _mesh(steps)
    picture = _picture(strokes())
    u, v = _uv(st, st[:, 0] > SIZE / 2).T
    row, column = np.clip(((1 - v) * SIDE).astype(int), 0, SIDE - 1), np.clip((u * SIDE).astype(int), 0, SIDE - 1)
    return place(st), faces, picture[row, column]
