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
from breastrig.report.visits.change import Change

LARGEST_MM = 15.0  # end of the colours, the same in every map, so that maps compare
LESS, MORE = np.array([0.10, 0.32, 0.66]), np.array([0.79, 0.38, 0.05])  # differ also without red and green
WITHIN, UNKNOWN, BESIDE = np.array([0.93, 0.92, 0.89]), np.array([0.62, 0.62, 0.62]), np.array([0.80, 0.78, 0.76])
FIRST = 0.25  # share of the colour with which what is said begins
VIEWS = ("three_quarter_right", "front", "three_quarter")
SIDE, BAR, TEXT = 420, 26, 15  # pixels


def change_colours(mm: Array, said: NDArray[np.bool_]) -> Array:
    """(M, 3) sRGB of (M,) mm: blue where skin went in, orange where it came out, pale where nothing is `said`."""
    share = FIRST + (1.0 - FIRST) * np.clip(np.abs(np.nan_to_num(mm)) / LARGEST_MM, 0.0, 1.0)[:, None]
    ends = np.where((mm < 0.0)[:, None], LESS, MORE)
    found = np.where(said[:, None], (1.0 - share) * WITHIN + share * ends, WITHIN)
    return np.asarray(np.where(np.isnan(mm)[:, None], UNKNOWN, found))


def _colours(change: Change) -> Array:
    colours = change_colours(1e3 * change.along, change.said)
    return np.asarray(np.where(change.of_breasts[:, None], colours, BESIDE))


def change_glb(change: Change) -> bytes:
    """The earlier fit's skin in its scan's frame, m; `extras` have each vertex's change and half band in mm."""
    mm = [None if np.isnan(each) else round(1e3 * float(each), 2) for each in change.along]
    extras: dict[str, Any] = {
        "notice": LIMITS_OF_USE,
        "change_mm": mm,
        "half_band_mm": np.round(1e3 * change.half, 2).tolist(),
        "colours": f"blue: in, orange: out, full at {LARGEST_MM:.0f} mm; pale: within the band; grey: not seen",
    }
    colours = np.rint(255.0 * _colours(change)).astype(np.uint8)
    return mesh_glb(change.earlier.vertices, change.earlier.rig.faces, colours=colours, extras=extras)


def change_ply(change: Change) -> bytes:
    """The same with colours and the properties change_mm (nan: not known) and half_band_mm of each vertex; metres."""
    faces = change.earlier.rig.faces
    kinds = dict.fromkeys(("x", "y", "z", "change_mm", "half_band_mm"), ("float", "<f4"))
    kinds |= dict.fromkeys(("red", "green", "blue"), ("uchar", "u1"))
    table = np.zeros(len(change.along), dtype=[(name, kind) for name, (_, kind) in kinds.items()])
    colours = np.rint(255.0 * _colours(change))
    columns = [*change.earlier.vertices.T, 1e3 * change.along, 1e3 * change.half, *colours.T]
    for name, column in zip(kinds, columns, strict=True):
        table[name] = column
    corners = np.zeros(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    corners["count"], corners["corners"] = 3, faces
    properties = [f"property {kind} {name}" for name, (kind, _) in kinds.items()]
    head = ["ply", "format binary_little_endian 1.0", f"comment {LIMITS_OF_USE}"]
    head += ["comment unit: m, frame: the earlier scan's", f"element vertex {len(table)}", *properties]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    return ("\n".join(head) + "\n").encode() + table.tobytes() + corners.tobytes()


def change_picture(change: Change) -> Image.Image:
    """Three views side by side over the colours' bar with its numbers."""
    scene = Scene([Layer(change.earlier.vertices, change.earlier.rig.faces, _colours(change))])
    views = [scene.render(view, (SIDE, SIDE)) for view in views_of(change.earlier, VIEWS, 1.0)]
    sheet = Image.new("RGB", (len(views) * SIDE, SIDE + BAR + 2 * TEXT), "white")
    for place, view in enumerate(views):
        sheet.paste(Image.fromarray(view), (place * SIDE, 0))
    pen, font = ImageDraw.Draw(sheet), ImageFont.load_default(TEXT)
    width, half = len(views) * SIDE - 80, 1e3 * float(np.nanmedian(change.half[change.of_breasts]))
    mm = np.linspace(-LARGEST_MM, LARGEST_MM, width)
    bar = np.broadcast_to(change_colours(mm, np.abs(mm) > half), (BAR, width, 3))
    sheet.paste(Image.fromarray(np.rint(255.0 * bar).astype(np.uint8)), (40, SIDE))
    for tick in np.arange(-LARGEST_MM, LARGEST_MM + 1.0, 5.0):
        at = 40 + round((tick + LARGEST_MM) / (2.0 * LARGEST_MM) * (width - 1))
        pen.text((at, SIDE + BAR + 2), f"{tick:+.0f} mm" if tick else "0", "black", font, anchor="ma")
    return sheet


def change_png(change: Change) -> bytes:
    """`change_picture` as PNG."""
    stream = io.BytesIO()
    change_picture(change).save(stream, "PNG", optimize=True)
    return stream.getvalue()
