"""A fitted model's .glb with the plan on it: lines and lesions, beside the rig, instead of the fit's own drawing.

They are in the frame of the scan (m), in which the rig is posed; they do not follow the replay, for they lie
on the scan and not on the model.
"""

import json
from collections.abc import Sequence
from typing import Any

from breastrig.core.glb import pack_glb, split_glb
from breastrig.gltf.lines.drawing_node import drawing_node
from breastrig.gltf.lines.lines_glb import Ball, NamedLine, lines_glb

PLAN_NODE = "plan"


def with_lines(fitted: bytes, lines: Sequence[NamedLine], balls: Sequence[Ball] = ()) -> bytes:
    """The .glb of a fit with these below the node `plan`; drawings of the fit itself are taken out of the scene.

    ValueError with the end of a sentence for what is no .glb.
    """
    document, binary = split_glb(fitted)
    scene = document["scenes"][document.get("scene", 0)]
    own = drawing_node("")
    scene["nodes"] = [k for k in scene["nodes"] if not document["nodes"][k].get("name", "").startswith(own)]
    if lines or balls:
        added, numbers = split_glb(lines_glb(lines, balls=balls))
        binary += b"\0" * (-len(binary) % 4)
        _append(document, added, len(binary))
        first = len(document["nodes"]) - len(added["nodes"])
        document["nodes"].append({"name": PLAN_NODE, "children": list(range(first, len(document["nodes"])))})
        scene["nodes"].append(len(document["nodes"]) - 1)
        binary += numbers
        document["buffers"][0]["byteLength"] = len(binary)
    return pack_glb(json.dumps(document, separators=(",", ":")).encode(), binary)


def _append(document: dict[str, Any], added: dict[str, Any], offset: int) -> None:
    """Puts the other document's things behind those that are there; its buffer begins at `offset`."""
    base = {kind: len(document.get(kind, [])) for kind in ("bufferViews", "accessors", "materials", "meshes")}
    for view in added["bufferViews"]:
        view["byteOffset"] = view.get("byteOffset", 0) + offset
    for accessor in added["accessors"]:
        accessor["bufferView"] += base["bufferViews"]
    for mesh in added["meshes"]:
        for primitive in mesh["primitives"]:
            primitive["attributes"] = {name: k + base["accessors"] for name, k in primitive["attributes"].items()}
            primitive["material"] += base["materials"]
            if "indices" in primitive:
                primitive["indices"] += base["accessors"]
    for node in added["nodes"]:
        node["mesh"] += base["meshes"]
    for kind in (*base, "nodes"):
        document.setdefault(kind, []).extend(added[kind])
    used = {*document.get("extensionsUsed", []), *added.get("extensionsUsed", [])}
    document["extensionsUsed"] = sorted(used)
