"""A scan as a GLB that Draco compressed, for tests of what unpacks it: also a program.

python draco_scan.py SCAN.ply OUT.glb
"""

import json
import sys
from pathlib import Path
from typing import Any

import DracoPy
import numpy as np
import trimesh

from breastrig.core.glb import pack_glb

EXTENSION = "KHR_draco_mesh_compression"
KINDS = {"POSITION": 0, "COLOR_0": 2, "TEXCOORD_0": 3}  # Draco's numbers of what an attribute is


def draco_glb(
    vertices: np.ndarray,
    faces: np.ndarray,
    colours: np.ndarray | None = None,
    uv: np.ndarray | None = None,
    texture: bytes | None = None,
) -> bytes:
    """(V, 3) vertices, (F, 3) faces, (V, 3) bytes of linear light, (V, 2) from the upper left, and its picture."""
    data = DracoPy.encode(
        np.asarray(vertices, np.float32),
        np.asarray(faces, np.uint32),
        quantization_bits=16,
        colors=None if colours is None else np.asarray(colours, np.uint8),
        tex_coord=None if uv is None else np.asarray(uv, np.float64),
    )
    ids = {each["attribute_type"]: each["unique_id"] for each in DracoPy.decode(data).attributes}
    compressed = {name: ids[kind] for name, kind in KINDS.items() if kind in ids}
    accessors: dict[str, dict[str, Any]] = {
        "POSITION": {"componentType": 5126, "type": "VEC3"},
        "COLOR_0": {"componentType": 5121, "type": "VEC3", "normalized": True},
        "TEXCOORD_0": {"componentType": 5126, "type": "VEC2"},
    }
    names = [name for name in accessors if name in compressed]
    primitive: dict[str, Any] = {
        "attributes": {name: index for index, name in enumerate(names)},
        "indices": len(names),
        "extensions": {EXTENSION: {"bufferView": 0, "attributes": compressed}},
    }
    document: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "extensionsUsed": [EXTENSION],
        "extensionsRequired": [EXTENSION],
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}],
        "accessors": [
            *({**accessors[name], "count": len(vertices)} for name in names),
            {"componentType": 5125, "type": "SCALAR", "count": 3 * len(faces)},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": len(data)}],
    }
    if texture is not None:
        primitive["material"] = 0
        document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
        document["textures"] = [{"source": 0}]
        document["images"] = [{"bufferView": 1, "mimeType": "image/jpeg"}]
        document["bufferViews"].append({"buffer": 0, "byteOffset": len(data), "byteLength": len(texture)})
        data += texture
    document["buffers"] = [{"byteLength": len(data)}]
    return pack_glb(json.dumps(document).encode(), data)


if __name__ == "__main__":
    scan = trimesh.load(sys.argv[1], process=False)
    Path(sys.argv[2]).write_bytes(draco_glb(scan.vertices, scan.faces))
