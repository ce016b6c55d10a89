"""The map of a change on the earlier skin: colours, a picture with its bar, GLB and PLY."""

import io
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from breastrig.core.arrays import Array
from breastrig.core.notice import LIMITS_OF_USE
from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.rendering.picture import Layer, Scene
from breastrig.report.pictures import views_of
from breastrig.report.visits.alignment import on_breasts
from breastrig.report.visits.change import Change

LARGEST_MM = 15.0  # end of the colours, the same in every map, so that maps compare
LESS, MORE = np.array([0.10, 0.32, 0.66]), np.array([0.79, 0.38, 0.05])  # differ also without red and green
WITHIN, UNKNOWN, BESIDE = np.array([0.93, 0.92, 0.89]), np.array([0.62, 0.62, 0.62]), np.array([0.80, 0.78, 0.76])
FIRST = 0.25  # share of the colour with which what is said begins
VIEWS = ("three_quarter_right", "front", "three_quarter")
SIDE, BAR, TEXT, MARGIN = 420, 26, 15, 40  # pixels


def change_colours(mm: Array, half: float) -> Array:
    """(M, 3) sRGB of (M,) mm: blue where skin went in, orange where it came out, pale up to `half` mm, grey for nan."""
    share = FIRST + (1.0 - FIRST) * np.clip(np.abs(np.nan_to_num(mm)) / LARGEST_MM, 0.0, 1.0)[:, None]
    found: Array = (1.0 - share) * WITHIN + share * np.where((mm < 0.0)[:, None], LESS, MORE)
    found[np.abs(mm) <= half] = WITHIN
    found[np.isnan(mm)] = UNKNOWN
    return found


def _colours(change: Change) -> Array:
    found, breasts = np.tile(BESIDE, (len(change.along), 1)), on_breasts(change.earlier.rig)
    found[breasts] = change_colours(1e3 * change.along[breasts], 1e3 * change.half)
    return found


def _bytes(colours: Array) -> NDArray[np.uint8]:
    return np.rint(255.0 * colours).astype(np.uint8)


def change_glb(change: Change) -> bytes:
    """The earlier fit's skin in its scan's frame, m; `extras` have each vertex's change and half its band in mm."""
    mm = [None if np.isnan(each) else round(1e3 * float(each), 2) for each in change.along]
    extras: dict[str, Any] = {
        "notice": LIMITS_OF_USE,
        "change_mm": mm,
        "half_band_mm": round(1e3 * change.half, 2),
        "colours": f"blue: in, orange: out, full at {LARGEST_MM:.0f} mm; pale: within the band; grey: not seen",
    }
    return mesh_glb(change.earlier.vertices, change.earlier.rig.faces, colours=_bytes(_colours(change)), extras=extras)


def change_ply(change: Change) -> bytes:
    """The same, with the property change_mm (nan: not known) of each vertex."""
    import trimesh  # slow to load

    mesh = trimesh.Trimesh(change.earlier.vertices, change.earlier.rig.faces, process=False)
    mesh.visual.vertex_colors = _bytes(_colours(change))
    mesh.vertex_attributes["change_mm"] = (1e3 * change.along).astype(np.float32)
    about = (
        f"comment {LIMITS_OF_USE}\ncomment unit: m, frame: the earlier scan's, half a band: {1e3 * change.half:.2f} mm"
    )
    return bytes(mesh.export(file_type="ply")).replace(b"comment https://github.com/mikedh/trimesh", about.encode(), 1)


def change_png(change: Change) -> bytes:
    """Three views side by side over the colours' bar with its numbers."""
    scene = Scene([Layer(change.earlier.vertices, change.earlier.rig.faces, _colours(change))])
    views = [scene.render(view, (SIDE, SIDE)) for view in views_of(change.earlier, VIEWS, 1.0)]
    across = len(views) * SIDE
    mm = np.linspace(-LARGEST_MM, LARGEST_MM, across - 2 * MARGIN)
    bar = np.tile(_bytes(change_colours(mm, 1e3 * change.half)), (BAR, 1, 1))
    sheet = Image.new("RGB", (across, SIDE + BAR + 2 * TEXT), "white")
    sheet.paste(Image.fromarray(np.concatenate(views, axis=1)))
    sheet.paste(Image.fromarray(bar), (MARGIN, SIDE))
    pen, font = ImageDraw.Draw(sheet), ImageFont.load_default(TEXT)
    for tick in range(-round(LARGEST_MM), round(LARGEST_MM) + 1, 5):
        at = MARGIN + float(np.interp(tick, mm, np.arange(len(mm))))
        pen.text((at, SIDE + BAR + 2), f"{tick:+d} mm" if tick else "0", "black", font, anchor="ma")
    stream = io.BytesIO()
    sheet.save(stream, "PNG", optimize=True)
    return stream.getvalue()
