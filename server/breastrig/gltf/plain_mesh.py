"""The shape alone of a mesh for display: what is shown of a scan when its colours are to stay private.

Skin colour, tattoos and birthmarks can identify a person; the shape says less.
"""

import numpy as np

from breastrig.core.glb import split_glb
from breastrig.core.gltf_arrays import GltfArrays
from breastrig.gltf.mesh_glb import mesh_glb


def plain_mesh(glb: bytes) -> bytes:
    """The same triangles and normals as in a .glb of `mesh_glb`, without texture and colours."""
    document, binary = split_glb(glb)
    arrays = GltfArrays(document, binary)
    primitive = document["meshes"][0]["primitives"][0]
    attributes = primitive["attributes"]
    faces = arrays.read(primitive["indices"]).reshape(-1, 3)
    place = np.array(document["nodes"][0].get("translation", [0.0, 0.0, 0.0]))
    return mesh_glb(arrays.read(attributes["POSITION"]) + place, faces, arrays.read(attributes["NORMAL"]))
