"""A surface as PLY and STL, in the unit that is asked for: single precision where that is exact, else more digits.

A PLY is two tables behind a few lines.  STL comes from trimesh, which takes 0.4 s to load, so it is loaded when one is
written: most commands, and the server, write none.
"""

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.single_precision import far_place

TRIANGLE = [("count", "u1"), ("corners", "<i4", 3)]


def surface_ply(vertices: Array, faces: Integers, metres_per_unit: float) -> bytes:
    """A binary PLY of (V, 3) m vertices and (F, 3) triangles."""
    kind, code = ("double", "<f8") if far_place(vertices).any() else ("float", "<f4")
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    lines += [f"property {kind} {axis}" for axis in "xyz"]
    lines += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    rows = np.zeros(len(faces), TRIANGLE)
    rows["count"], rows["corners"] = 3, faces
    return "\n".join(lines).encode() + (vertices / metres_per_unit).astype(code).tobytes() + rows.tobytes()


def surface_stl(vertices: Array, faces: Integers, metres_per_unit: float) -> bytes:
    """An STL of (V, 3) m vertices and (F, 3) triangles: binary, or text where that would round."""
    import trimesh

    mesh = trimesh.Trimesh(vertices / metres_per_unit, faces, process=False)
    if not far_place(vertices).any():
        return bytes(mesh.export(file_type="stl"))
    return str(mesh.export(file_type="stl_ascii")).encode()
