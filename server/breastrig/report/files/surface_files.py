"""A surface as PLY and STL, in the unit that is asked for: single precision where that is exact, else more digits.

The STL comes from trimesh, which takes 0.4 s to load, so it is loaded when one is written; a PLY is two arrays.
"""

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.single_precision import far_place


def surface_ply(vertices: Array, faces: Integers, metres_per_unit: float) -> bytes:
    """A binary PLY of (V, 3) m vertices and (F, 3) triangles."""
    exact = not far_place(vertices).any()
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(vertices)}",
        *(f"property {'float' if exact else 'double'} {axis}" for axis in "xyz"),
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header\n",
    ]
    triangles = np.zeros(len(faces), [("count", "<u1"), ("corners", "<i4", 3)])
    triangles["count"], triangles["corners"] = 3, faces
    places = (vertices / metres_per_unit).astype("<f4" if exact else "<f8")
    return "\n".join(header).encode() + places.tobytes() + triangles.tobytes()


def surface_stl(vertices: Array, faces: Integers, metres_per_unit: float) -> bytes:
    """An STL of (V, 3) m vertices and (F, 3) triangles: binary, or text where that would round."""
    import trimesh

    mesh = trimesh.Trimesh(vertices / metres_per_unit, faces, process=False)
    if not far_place(vertices).any():
        return bytes(mesh.export(file_type="stl"))
    return str(mesh.export(file_type="stl_ascii")).encode()
