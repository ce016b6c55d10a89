"""The mesh of a scan as the page shows it, with all that the page would have to find out by itself.

The body's triangles come first, those of tables, walls and loose pieces after them; all face outwards.  A scan without
colours is shaded by how much it bends (rendering/folds.py).  The rims of the body's holes stand beside it as lines.
"""

import json

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.glb import pack_glb, split_glb
from breastrig.geometry.boundary import boundary_edges
from breastrig.geometry.normals import face_crosses
from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.rendering.folds import shades
from breastrig.scan.clean import Surface, welded
from breastrig.scan.scan import Scan
from breastrig.scan.winding import outwards


def scan_mesh(scan: Scan, body: Surface) -> tuple[bytes, int]:
    """A .glb of a scan, and how many of its triangles, the first ones, are those of the cleaned `body`."""
    faces = _facing_outwards(scan)
    is_body = np.ones(len(faces), dtype=np.bool_)
    if len(faces) > len(body.faces):
        is_body = _are_of(body, scan.vertices, faces)
    faces = np.concatenate([faces[is_body], faces[~is_body]])
    plain = scan.colours is None and scan.texture is None
    vertices, own = welded(scan.vertices, faces[: np.count_nonzero(is_body)])  # seams of a texture are no rims
    glb = mesh_glb(
        scan.vertices,
        faces,
        colours=scan.colours,
        uv=scan.uv,
        texture=scan.texture,
        shades=shades(scan.vertices, faces) if plain else None,
        rims=vertices[boundary_edges(own)],
    )
    return glb, int(np.count_nonzero(is_body))


def scaled_mesh(glb: bytes, factor: float) -> bytes:
    """The .glb of `scan_mesh` so many times as large about the origin of the scan's frame: its nodes say so."""
    document, binary = split_glb(glb)
    for node in document["nodes"]:
        node["scale"] = [factor] * 3
        if "translation" in node:
            node["translation"] = [factor * value for value in node["translation"]]
    return pack_glb(json.dumps(document, separators=(",", ":")).encode(), binary)


def _facing_outwards(scan: Scan) -> Integers:
    vertices, faces = welded(scan.vertices, scan.faces)
    turned, count = outwards(vertices, faces, face_crosses(vertices, faces))
    if not count:
        return scan.faces
    is_turned = (turned != faces).any(axis=1)
    return np.where(is_turned[:, None], scan.faces[:, ::-1], scan.faces)


def _are_of(body: Surface, vertices: Array, faces: Integers) -> Booleans:
    """(F,) which triangles have all corners on the body's."""
    places, corners = welded(
        np.concatenate([vertices, body.vertices]), np.concatenate([faces, body.faces + len(vertices)])
    )
    on_body = np.zeros(len(places), dtype=np.bool_)
    on_body[corners[len(faces) :]] = True
    return np.asarray(on_body[corners[: len(faces)]].all(axis=1))
