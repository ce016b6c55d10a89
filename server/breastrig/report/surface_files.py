"""A surface as PLY and STL, in the unit that is asked for: single precision where that is exact, else more digits.

Both come from trimesh, whose PLY knows single precision only: far from the origin the vertices are written anew.
It takes 0.4 s to load, so it is loaded when a surface is written: most commands, and the server, write none.
"""

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.single_precision import far_place


def surface_ply(vertices: Array, faces: Integers, metres_per_unit: float) -> bytes:
    """A binary PLY of (V, 3) m vertices and (F, 3) triangles."""
    import trimesh

    placed = vertices / metres_per_unit
    data = bytes(trimesh.Trimesh(placed, faces, process=False).export(file_type="ply", include_attributes=False))
    if not far_place(vertices).any():
        return data
    header, body = data.split(b"end_header\n", 1)
    triangles = body[len(placed) * 3 * np.dtype(np.float32).itemsize :]
    return header.replace(b"float", b"double") + b"end_header\n" + placed.astype("<f8").tobytes() + triangles


def surface_stl(vertices: Array, faces: Integers, metres_per_unit: float) -> bytes:
    """An STL of (V, 3) m vertices and (F, 3) triangles: binary, or text where that would round."""
    import trimesh

    mesh = trimesh.Trimesh(vertices / metres_per_unit, faces, process=False)
    if not far_place(vertices).any():
        return bytes(mesh.export(file_type="stl"))
    return str(mesh.export(file_type="stl_ascii")).encode()
