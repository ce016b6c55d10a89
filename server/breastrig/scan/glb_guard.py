"""Looks at an uploaded .glb's JSON before a library does: nothing outside, nothing compressed, nothing endless.

A .glb can name other files or addresses, hide its geometry in a compression whose decoded indices nobody
checks, build a scene that contains itself, or claim arrays of any length.  All of that is refused here by
reading the JSON alone; pictures that are neither JPEG nor PNG are taken out.  Vertex colours are given a
name that the library hands through untouched, because it mixes up their number formats.
"""

import base64
import json
from typing import Any

from breastrig.core.errors import BadScan, TooLarge
from breastrig.core.glb import pack_glb, split_glb
from breastrig.scan.limits import GLTF_NODES, TRIANGLES, VERTICES
from breastrig.scan.texture import is_picture

HARMLESS = ("KHR_materials_", "KHR_texture_transform", "KHR_lights_punctual", "EXT_materials_")
HIDDEN_COLOURS = "_BREASTRIG_COLOUR"
COMPRESSED = ("KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression")


def guarded(data: bytes) -> tuple[bytes, tuple[str, ...]]:
    """(the .glb, its vertex colours renamed, possibly without its pictures; notes).

    Raises BadScan or TooLarge with a sentence.
    """
    try:
        document, binary = split_glb(data)
        _check_extensions(document)
        _check_addresses(document)
        _check_counts(document)
        _check_tree(document)
        kept = _pictures_kept(document, binary)
    except (ValueError, TypeError, KeyError, IndexError, AttributeError, RecursionError) as error:
        reason = str(error) if type(error) is ValueError else "its structure is broken"
        raise BadScan(f"This GLB file cannot be read: {reason}; export it again.") from error
    primitives = [primitive for mesh in document.get("meshes", []) for primitive in mesh["primitives"]]
    for primitive in primitives:
        if "COLOR_0" in primitive["attributes"]:
            primitive["attributes"][HIDDEN_COLOURS] = primitive["attributes"].pop("COLOR_0")
    if not kept:
        for key in ("images", "textures", "materials", "samplers"):
            document.pop(key, None)
        for primitive in primitives:
            primitive.pop("material", None)
    note = "The texture is neither JPEG nor PNG, or damaged, and was left out."
    return pack_glb(json.dumps(document).encode(), binary), () if kept else (note,)


def _check_extensions(document: dict[str, Any]) -> None:
    used = {*document.get("extensionsUsed", []), *document.get("extensionsRequired", [])}
    if used & set(COMPRESSED) or any(name in json.dumps(document.get("meshes", [])) for name in COMPRESSED):
        raise BadScan("This GLB file is compressed (Draco or meshopt); export it without compression.")
    for name in document.get("extensionsRequired", []):
        if not str(name).startswith(HARMLESS):
            raise BadScan("This GLB file needs a glTF extension that is not read here; export it as plain glTF 2.0.")


def _check_addresses(document: dict[str, Any]) -> None:
    for kind in ("buffers", "images"):
        for entry in document.get(kind, []):
            if "uri" in entry and not str(entry["uri"]).startswith("data:"):
                raise BadScan("This GLB file points to other files; export it with everything inside.")


def _check_counts(document: dict[str, Any]) -> None:
    accessors = document.get("accessors", [])
    for accessor in accessors:
        count = accessor.get("count")
        if not isinstance(count, int) or isinstance(count, bool) or count < 0:
            raise ValueError("an array has no proper length")
    instances: dict[int, int] = {}
    for node in document.get("nodes", []):
        if "mesh" in node:
            instances[node["mesh"]] = instances.get(node["mesh"], 0) + 1
    triangles = vertices = 0
    for index, mesh in enumerate(document.get("meshes", [])):
        for primitive in mesh["primitives"]:
            points = accessors[primitive["attributes"]["POSITION"]]["count"]
            corners = accessors[primitive["indices"]]["count"] if "indices" in primitive else points
            triangles += instances.get(index, 1) * corners // 3
            vertices += instances.get(index, 1) * points
    if triangles > TRIANGLES or vertices > VERTICES or max((a["count"] for a in accessors), default=0) > VERTICES:
        raise TooLarge(f"This scan has more than the {TRIANGLES:,} triangles allowed; simplify it first.")


def _check_tree(document: dict[str, Any]) -> None:
    """Nodes must form trees: a node with two parents could be its own ancestor, and readers would never return."""
    nodes = document.get("nodes", [])
    if len(nodes) > GLTF_NODES:
        raise TooLarge(
            f"This GLB file has {len(nodes):,} nodes, more than the {GLTF_NODES:,} allowed; join its meshes."
        )
    parents: dict[int, int] = {}
    for index, node in enumerate(nodes):
        for child in node.get("children", []):
            if not 0 <= child < len(nodes) or child in parents:
                raise ValueError("its scene is no tree")
            parents[child] = index
    for start in range(len(nodes)):
        node, steps = start, 0
        while node in parents:
            node, steps = parents[node], steps + 1
            if steps > len(nodes):
                raise ValueError("its scene contains itself")
            if steps > 200:
                raise ValueError("its scene is nested too deeply")


def _pictures_kept(document: dict[str, Any], binary: bytes) -> bool:
    """Whether all pictures are readable JPEG or PNG."""
    for image in document.get("images", []):
        if "uri" in image:
            content = base64.b64decode(image["uri"].split(",", 1)[1])
        else:
            view = document["bufferViews"][image["bufferView"]]
            start = view.get("byteOffset", 0)
            content = binary[start : start + view["byteLength"]]
        if not is_picture(content):
            return False
    return True
