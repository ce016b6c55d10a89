"""The shape alone of a mesh for display: what is shown of a scan when its colours are to stay private.

Skin colour, tattoos and birthmarks can identify a person; the shape says less.  Nor is there what a person has cut away
by hand, a face perhaps.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from breastrig.core.glb import split_glb
from breastrig.core.gltf_arrays import GltfArrays
from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.scan.hand_cuts import HandCut, cut_triangles


def plain_mesh(glb: bytes, cuts: Sequence[Mapping[str, Any]] = ()) -> bytes:
    """The same triangles and normals as in a .glb of `mesh_glb`, without texture and colours.

    `cuts` are documents as HandCut.of reads them: what they cut is not there, its vertices neither.
    """
    document, binary = split_glb(glb)
    arrays = GltfArrays(document, binary)
    primitive = document["meshes"][0]["primitives"][0]
    attributes = primitive["attributes"]
    faces = arrays.read(primitive["indices"]).reshape(-1, 3)
    place = np.array(document["nodes"][0].get("translation", [0.0, 0.0, 0.0]))
    vertices, normals = arrays.read(attributes["POSITION"]) + place, arrays.read(attributes["NORMAL"])
    if cuts:
        faces = faces[~cut_triangles(vertices, faces, [HandCut.of(cut) for cut in cuts])]
        used, ours = np.unique(faces, return_inverse=True)
        vertices, normals, faces = vertices[used], normals[used], ours.reshape(-1, 3)
    return mesh_glb(vertices, faces, normals)
