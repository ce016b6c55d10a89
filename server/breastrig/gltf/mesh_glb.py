"""A static mesh as .glb: the scan for the page, with its colours or its texture.

Colours and textures of scans are sRGB; glTF takes vertex colours as linear light, so they are converted, with
16 bits where 8 would show bands.  Texture coordinates come with their origin at the lower left (as in OBJ)
and are turned over for glTF.  A mesh far from the origin lies around its own middle, where its node moves it to.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pygltflib import (
    ARRAY_BUFFER,
    ELEMENT_ARRAY_BUFFER,
    LINEAR,
    LINEAR_MIPMAP_LINEAR,
    LINES,
    Image,
    Material,
    Mesh,
    PbrMetallicRoughness,
    Primitive,
    Sampler,
    Texture,
    TextureInfo,
)

from breastrig.core.arrays import Array, Integers
from breastrig.core.single_precision import far_place
from breastrig.core.srgb import to_light
from breastrig.geometry.normals import vertex_normals
from breastrig.gltf.container import BufferWriter, append, moved_to, new_document, to_glb
from breastrig.gltf.document import Attributes, Document, Node
from breastrig.gltf.skinned import as_float32

GREY = [0.55, 0.57, 0.60, 1.0]  # linear RGB of a cool matte grey
WHITE = [1.0, 1.0, 1.0, 1.0]  # lets colours and textures through
ROUGHNESS = 0.9
IMAGE_TYPES = {b"\xff\xd8\xff": "image/jpeg", b"\x89PN": "image/png"}


def mesh_glb(
    vertices: Array,
    faces: Integers,
    normals: Array | None = None,
    colours: NDArray[np.uint8] | None = None,
    uv: Array | None = None,
    texture: bytes | None = None,
    extras: dict[str, Any] | None = None,
    rims: Array | None = None,
    shades: NDArray[np.uint8] | None = None,
) -> bytes:
    """A .glb of (V, 3) m vertices and (F, 3) triangles.

    normals (V, 3) unit, computed when absent; colours (V, 3 or 4) uint8 sRGB; uv (V, 2) with the origin at the
    lower left and texture, the bytes of a PNG or JPEG, go together and win over colours.  rims (E, 2, 3)
    m are both ends of lines that are drawn with it.  shades (V, 3) uint8 sRGB are for a mesh without any colours: greys
    that say nothing but its shape, which its extras tell apart by `shaded`.
    """
    document = new_document(extras)
    buffer = BufferWriter(document)
    on_vertices = ARRAY_BUFFER
    place = far_place(vertices)
    unit = vertex_normals(vertices, faces) if normals is None else normals
    attributes = Attributes(
        POSITION=buffer.add(as_float32(vertices - place), target=on_vertices, bounds=True),
        NORMAL=buffer.add(as_float32(unit), target=on_vertices),
    )
    material = _matte(GREY)
    if uv is not None and texture is not None:
        attributes["TEXCOORD_0"] = buffer.add(as_float32(uv * [1.0, -1.0] + [0.0, 1.0]), target=on_vertices)
        material = _matte(WHITE, _texture(document, buffer, texture))
    elif (tints := shades if colours is None else colours) is not None:
        attributes["COLOR_0"] = buffer.add(_linear(tints), target=on_vertices, normalized=True)
        material = _matte(WHITE)
    index_type = np.uint16 if len(vertices) < np.iinfo(np.uint16).max else np.uint32
    primitive = Primitive(
        attributes=attributes,
        indices=buffer.add(faces.ravel().astype(index_type), target=ELEMENT_ARRAY_BUFFER),
        material=append(document.materials, material),
    )
    marks = {"shaded": True} if shades is not None else {}
    primitives = [primitive]
    if rims is not None and len(rims):
        ends = buffer.add(as_float32(rims.reshape(-1, 3) - place), target=on_vertices, bounds=True)
        primitives.append(Primitive(attributes=Attributes(POSITION=ends), mode=LINES))
    mesh = append(document.meshes, Mesh(name="mesh", primitives=primitives, extras=marks))
    document.scenes[0].nodes = [append(document.nodes, Node(name="mesh", mesh=mesh, translation=moved_to(place)))]
    return to_glb(document, buffer)


def _linear(colours: NDArray[np.uint8]) -> NDArray[np.uint16]:
    """(V, 4) linear light of (V, 3 or 4) sRGB, opaque."""
    result = np.full((len(colours), 4), np.iinfo(np.uint16).max, np.uint16)
    levels = np.round(np.iinfo(np.uint16).max * to_light(np.arange(256) / 255.0)).astype(np.uint16)
    result[:, :3] = levels[colours[:, :3]]
    return result


def _texture(document: Document, buffer: BufferWriter, image: bytes) -> TextureInfo:
    source = append(document.images, Image(mimeType=IMAGE_TYPES[image[:3]], bufferView=buffer.add_bytes(image)))
    sampler = append(
        document.samplers,
        Sampler(magFilter=LINEAR, minFilter=LINEAR_MIPMAP_LINEAR),
    )
    return TextureInfo(index=append(document.textures, Texture(sampler=sampler, source=source)))


def _matte(color: list[float], texture: TextureInfo | None = None) -> Material:
    return Material(
        name="scan",
        doubleSided=True,  # a scan is an open sheet
        pbrMetallicRoughness=PbrMetallicRoughness(
            baseColorFactor=color, metallicFactor=0.0, roughnessFactor=ROUGHNESS, baseColorTexture=texture
        ),
    )
