"""Polylines and balls as .glb, alone or in the .glb of a fit: a node for each, in metres, in the frame of the points.

Line strips, not ribbons (ribbon.py): this is for programs that compute with the lines, not for looking.  They do not
follow a fit's replay, for they lie on the scan and in it, and not on the model.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pygltflib import ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, LINE_LOOP, LINE_STRIP, POINTS, Mesh, Primitive

from breastrig.core.arrays import Array
from breastrig.core.glb import pack_glb, split_glb
from breastrig.core.single_precision import far_place
from breastrig.gltf.container import UNLIT, BufferWriter, append, moved_to, new_document, to_glb, unlit
from breastrig.gltf.document import Attributes, Document, Node
from breastrig.gltf.lines.drawing_node import drawing_node
from breastrig.gltf.skinned import as_float32

Colour = tuple[int, int, int]  # red green blue of 0 to 255
NamedLine = tuple[str, Array, bool, Colour]  # name, (M, 3) m, closed


@dataclass(frozen=True, eq=False)
class Ball:
    """A ball with a node of its own, and its extras for programs."""

    name: str
    center: Array  # (3,) m
    radius: float  # m
    color: Colour
    extras: dict[str, Any]


def lines_glb(lines: Sequence[NamedLine], extras: dict[str, Any] | None = None, balls: Sequence[Ball] = ()) -> bytes:
    """A .glb of these lines and balls."""
    document = new_document(extras)
    buffer = BufferWriter(document)
    if lines or balls:
        document.extensionsUsed = [UNLIT]
    place = far_place(np.concatenate([np.zeros((0, 3)), *(points for _, points, _, _ in lines)]))
    for name, points, is_closed, colour in lines:
        mode = POINTS if len(points) == 1 else LINE_LOOP if is_closed else LINE_STRIP
        primitive = Primitive(
            attributes=Attributes(
                POSITION=buffer.add(as_float32(points - place), target=ARRAY_BUFFER, bounds=True),
            ),
            mode=mode,
            material=append(document.materials, unlit("pen", colour)),
        )
        mesh = append(document.meshes, Mesh(name=name, primitives=[primitive]))
        document.scenes[0].nodes.append(append(document.nodes, Node(name=name, mesh=mesh, translation=moved_to(place))))
    if balls:
        _add_balls(document, buffer, balls)
    return to_glb(document, buffer)


def _add_balls(document: Document, buffer: BufferWriter, balls: Sequence[Ball]) -> None:
    from trimesh.creation import icosphere  # 0.4 s, which lines alone need not wait for

    unit = icosphere(subdivisions=3)
    attributes = Attributes(POSITION=buffer.add(as_float32(unit.vertices), target=ARRAY_BUFFER, bounds=True))
    indices = buffer.add(unit.faces.ravel().astype(np.uint16), target=ELEMENT_ARRAY_BUFFER)
    for ball in balls:
        surface = Primitive(
            attributes=attributes, indices=indices, material=append(document.materials, unlit("pen", ball.color))
        )
        mesh = append(document.meshes, Mesh(name=ball.name, primitives=[surface]))
        place, size = [float(value) for value in ball.center], [ball.radius] * 3
        node = Node(name=ball.name, mesh=mesh, translation=place, scale=size, extras=ball.extras)
        document.scenes[0].nodes.append(append(document.nodes, node))


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
