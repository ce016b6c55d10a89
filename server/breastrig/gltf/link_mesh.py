"""The mesh of a scan as share links show it: what is visible of it and nothing more, with or without its colours.

Skin colour, tattoos and birthmarks can identify a person; the shape says less.  What is not seen any more, cut away by
hand (a face perhaps), as table or as a piece beside her, is not there at all: no triangles, no vertices, and nothing
of the texture that only they showed.
"""

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans
from breastrig.gltf.covered_texture import covered_texture
from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.scan.clean import Surface
from breastrig.scan.scan import Scan

SAME = 1e-5  # m between the middles of what is one triangle; files with single precision are 1e-7 off


def plain_mesh(visible: Surface) -> bytes:
    """A .glb of the visible part of a scan, without colours."""
    return mesh_glb(visible.vertices, visible.faces)


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
