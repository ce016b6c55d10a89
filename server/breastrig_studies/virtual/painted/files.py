"""The files of a painted scan: scan.zip with OBJ, MTL and JPEG, and the truth of ink and skin beside the usual ones."""

import io
import zipfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.geometry.surface_points import SurfacePoints
from breastrig_studies.virtual.bodies import VirtualBody
from breastrig_studies.virtual.case_files import moved, placed_at_random, write_json, write_known
from breastrig_studies.virtual.painted.atlas import Atlas
from breastrig_studies.virtual.painted.marks import NATURAL, Areola, Marks, Stroke
from breastrig_studies.virtual.painted.photograph import Photograph
from breastrig_studies.virtual.scan import SimulatedScan

SEEN = 0.006  # m; a point of the true skin with scan this near is shown
EPOCH = (2026, 1, 1, 0, 0, 0)  # of the entries in the zip, so that the same scan has the same bytes
MATERIAL = "newmtl skin\nKa 1 1 1\nKd 1 1 1\nillum 1\nmap_Kd texture.jpg\n"
AREOLA_COLOR, SCAR_COLOR = "#804030", "#808080"


def scan_zip(vertices: Array, faces: Integers, atlas: Atlas, jpeg: bytes, decimals: int) -> bytes:
    """OBJ, MTL and texture of (V, 3) vertices in the scan's unit."""
    uv = np.round(atlas.uv.reshape(-1, 2), 6)
    unique, index = np.unique(uv, axis=0, return_inverse=True)
    index = index.reshape(-1, 3)
    lines = ["mtllib scan.mtl", "usemtl skin"]
    lines += [f"v {x:.{decimals}f} {y:.{decimals}f} {z:.{decimals}f}" for x, y, z in vertices.tolist()]
    lines += [f"vt {u:.6f} {v:.6f}" for u, v in unique.tolist()]
    lines += [
        f"f {a}/{p} {b}/{q} {c}/{r}"
        for (a, b, c), (p, q, r) in zip((faces + 1).tolist(), (index + 1).tolist(), strict=True)
    ]
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in (
            ("scan.obj", ("\n".join(lines) + "\n").encode()),
            ("scan.mtl", MATERIAL.encode()),
            ("texture.jpg", jpeg),
        ):
            archive.writestr(zipfile.ZipInfo(name, EPOCH), data, zipfile.ZIP_DEFLATED)
    return stream.getvalue()


def write_painted_case(
    place: Path,
    body: VirtualBody,
    skin: Integers,
    scan: SimulatedScan,
    atlas: Atlas,
    picture: Photograph,
    marks: Marks,
    inked: bool,
    unit: str,
    random: np.random.Generator,
    more: dict[str, Any],
) -> Array:
    """Everything of one stance; returns the (4, 4) that moves body coordinates (m) into the scan's frame and unit."""
    placed = placed_at_random(unit, random)
    place.mkdir(parents=True, exist_ok=True)
    vertices = moved(scan.vertices, placed)
    data = scan_zip(vertices, scan.faces, atlas, picture.jpeg, decimals=3 if unit == "mm" else 6)
    (place / "scan.zip").write_bytes(data)
    nipples = {f"nipple_{areola.side}": areola.state for areola in marks.areolae}
    about = {
        "inked": inked,
        "texel_mm": round(1e3 * atlas.texel, 2),
        "charts": atlas.charts,
        "texture_blur_texels": round(picture.blur, 2),
        "jpeg_quality": picture.quality,
        "nipples": nipples,
    }
    write_known(place, body, skin, scan, unit, placed, about | more)
    shown = cKDTree(scan.vertices)

    def shape(stroke: Stroke, with_ink: bool) -> dict[str, Any]:
        entry = _shape(body, skin, stroke.name, stroke.closed, stroke.color, stroke.points, placed, unit, shown)
        if with_ink:
            entry["inked"] = stroke.inked.tolist()
        return entry

    strokes = marks.ink if inked else ()
    write_shapes(place / "ink.json", unit, [shape(stroke, True) for stroke in strokes])
    rims = [rim_shape(body, skin, areola, placed, unit, shown) for areola in marks.areolae if areola.state == NATURAL]
    write_shapes(place / "skin.json", unit, [*rims, *(shape(scar, False) for scar in marks.scars)])
    return placed


def rim_shape(
    body: VirtualBody, skin: Integers, areola: Areola, placed: Array, unit: str, shown: cKDTree | None = None
) -> dict[str, Any]:
    """The true border of an areola as files have it."""
    return _shape(body, skin, f"areola_{areola.side}", True, AREOLA_COLOR, areola.rim, placed, unit, shown)


def strokes_elsewhere(
    body: VirtualBody, skin: Integers, strokes: Iterable[Stroke], placed: Array, unit: str
) -> list[dict[str, Any]]:
    """The strokes at the same points of the skin in another stance: the truth for a transferred drawing."""
    return [_shape(body, skin, s.name, s.closed, s.color, s.points, placed, unit, None) for s in strokes]


def write_shapes(path: Path, unit: str, shapes: list[dict[str, Any]]) -> None:
    """A drawing file."""
    write_json(path, {"schema": "breastrig/drawing@1", "unit": unit, "shapes": shapes, "notice": LIMITS_OF_USE})


def _shape(
    body: VirtualBody,
    skin: Integers,
    name: str,
    closed: bool,
    color: str,
    points: SurfacePoints,
    placed: Array,
    unit: str,
    shown: cKDTree | None,
) -> dict[str, Any]:
    places = points.positions(body.vertices, skin)
    rounded = np.round(moved(places, placed), 3 if unit == "mm" else 6)
    entry: dict[str, Any] = {"name": name, "closed": closed, "color": color, "points": rounded.tolist()}
    if shown is not None:
        gaps, _ = shown.query(places)
        seen: Booleans = np.asarray(gaps < SEEN)
        entry["seen"] = seen.tolist()
    return entry
