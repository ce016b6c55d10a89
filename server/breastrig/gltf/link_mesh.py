"""The mesh of a scan as share links show it: with or without its colours, and never with what was cut away by hand.

Skin colour, tattoos and birthmarks can identify a person; the shape says less.  What a person has cut away, a face
perhaps, is not there at all: no triangles, no vertices, and nothing of the texture that only they showed.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.glb import split_glb
from breastrig.core.gltf_arrays import GltfArrays
from breastrig.gltf.covered_texture import covered_texture
from breastrig.gltf.mesh_glb import mesh_glb, srgb
from breastrig.scan.clean import welded
from breastrig.scan.hand_cuts import HandCut, cut_triangles

Cuts = Sequence[Mapping[str, Any]]  # documents as HandCut.of reads them


def plain_mesh(glb: bytes, cuts: Cuts = ()) -> bytes:
    """A .glb of `mesh_glb` without its texture and colours, and without what is cut."""
    return _left(glb, cuts, has_colours=False)


def coloured_mesh(glb: bytes, cuts: Cuts) -> bytes:
    """A .glb of `mesh_glb` with its texture or colours, without what is cut."""
    return _left(glb, cuts, has_colours=True)


def _left(glb: bytes, cuts: Cuts, has_colours: bool) -> bytes:
    document, binary = split_glb(glb)
    arrays = GltfArrays(document, binary)
    primitive = document["meshes"][0]["primitives"][0]
    faces = arrays.read(primitive["indices"]).reshape(-1, 3)
    place = np.array(document["nodes"][0].get("translation", [0.0, 0.0, 0.0]))
    stored = {name: arrays.read(index) for name, index in primitive["attributes"].items() if name != "COLOR_0"}
    if "COLOR_0" in primitive["attributes"]:
        stored["COLOR_0"] = srgb(arrays.stored(primitive["attributes"]["COLOR_0"]))
    stored["POSITION"] = stored["POSITION"] + place
    if cuts:
        faces = faces[~cut_triangles(stored["POSITION"], faces, [HandCut.of(cut) for cut in cuts])]
        used, ours = np.unique(faces, return_inverse=True)
        stored = {name: values[used] for name, values in stored.items()}
        faces = ours.reshape(-1, 3)
    vertices, normals = stored["POSITION"], stored["NORMAL"]
    if not has_colours:
        # Where pieces of a texture meet is the texture's matter, and a viewer would draw it as a border.
        joined, faces = welded(vertices, faces)
        return mesh_glb(joined, faces, normals if joined is vertices else None)
    uv: Array | None = None
    texture: bytes | None = None
    if "TEXCOORD_0" in stored:
        uv = stored["TEXCOORD_0"] * [1.0, -1.0] + [0.0, 1.0]
        texture = covered_texture(_picture(document, binary), uv[faces])
    return mesh_glb(vertices, faces, normals, stored.get("COLOR_0"), uv, texture)


def _picture(document: Mapping[str, Any], binary: bytes) -> bytes:
    view = document["bufferViews"][document["images"][0]["bufferView"]]
    start = view.get("byteOffset", 0)
    return binary[start : start + view["byteLength"]]
