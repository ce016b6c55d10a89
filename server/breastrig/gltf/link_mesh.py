"""The mesh of a scan as share links show it: only its visible part, with or without colours.

Skin colour, tattoos and birthmarks can identify a person; the shape says less. Parts that are cut away, by hand (a face
perhaps), as table or as a piece beside the patient, are absent: no triangles, no vertices, and nothing in the picture.
"""

import io

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans
from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.rendering.folds import shades
from breastrig.scan.clean import Surface
from breastrig.scan.scan import Scan

BORDER = 2  # pixels around the triangles: what the next coarser picture of a mipmap mixes with theirs
QUALITY = 92  # of the JPEG: it is the second time that it is written, and pen strokes are thin


def covered_texture(picture: bytes, corners: Array) -> bytes:
    """The JPEG of a picture's pixels under the triangles: (F, 3, 2) corners, origin at the lower left, repeating."""
    from PIL import Image, ImageDraw, ImageFilter  # half a tenth of a second, and few scans come this way

    with Image.open(io.BytesIO(picture), formats=("PNG", "JPEG")) as opened:
        pixels = np.array(opened.convert("RGB"))
    height, width = pixels.shape[:2]
    mask = Image.new("L", (width, height), 0)
    draw = ImageDraw.Draw(mask)
    tiles = corners - np.floor(corners.min(axis=1, keepdims=True))  # they begin in the first repetition
    for right, up in ((0, 0), (1, 0), (0, 1), (1, 1)):
        there = tiles - [right, up]
        seen = there[(there.max(axis=1) >= 0.0).all(axis=1)]
        places = np.stack((seen[..., 0] * width, (1.0 - seen[..., 1]) * height), axis=-1) - 0.5
        for triangle in np.clip(places, -2.0 * max(width, height), 3.0 * max(width, height)).reshape(-1, 6).tolist():
            draw.polygon(triangle, fill=255, outline=255)
    shown = np.asarray(mask.filter(ImageFilter.MaxFilter(2 * BORDER + 1))) > 0
    if shown.any():
        pixels[~shown] = np.round(pixels[shown].mean(axis=0))
    else:
        pixels[:] = 0
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "JPEG", quality=QUALITY, subsampling=0)
    return stream.getvalue()


SAME = 1e-5  # m between the middles of what is one triangle; files with single precision are 1e-7 off


def plain_mesh(visible: Surface) -> bytes:
    """A .glb of the visible part of a scan, without its colours; shaded by how much it bends."""
    return mesh_glb(visible.vertices, visible.faces, shades=shades(visible.vertices, visible.faces))


def coloured_mesh(scan: Scan, visible: Surface) -> bytes:
    """A .glb of the scan's triangles that are visible, with its texture or colours."""
    faces = scan.faces[_are_among(scan.vertices[scan.faces].mean(axis=1), visible)]
    used, ours = np.unique(faces, return_inverse=True)
    vertices, faces = scan.vertices[used], ours.reshape(-1, 3)
    if scan.uv is not None and scan.texture is not None:
        uv = scan.uv[used]
        return mesh_glb(vertices, faces, uv=uv, texture=covered_texture(scan.texture, uv[faces]))
    if scan.colours is not None:
        return mesh_glb(vertices, faces, colours=scan.colours[used])
    return plain_mesh(visible)


def _are_among(middles: Array, visible: Surface) -> Booleans:
    """(F,) which of the (F, 3) m middles of triangles are those of visible ones."""
    there = cKDTree(visible.vertices[visible.faces].mean(axis=1))
    distances, _ = there.query(middles, distance_upper_bound=SAME)
    return np.asarray(np.isfinite(distances))
