"""GLB documents that ask for much in few bytes, and sparse arrays of any numbers: read soundly or one sentence."""

import json
from typing import Any

import numpy as np
from helpers.damage import bounded
from helpers.refusals import refused_or_sound
from helpers.toy_rig import toy_rig
from hypothesis import given
from hypothesis import strategies as st

from breastrig.core.glb import pack_glb, split_glb
from breastrig.gltf.mesh_glb import mesh_glb

RIG = toy_rig()
COUNTS = st.sampled_from([0, 1, 2, 7, 100, 101, 1999, 2001, 10_001, 20_001])
NUMBERS = st.one_of(st.integers(-2, 300), st.sampled_from([2**31, 2**40, -(2**40), None, 0.5, "1", [], {}]))
MODES = st.sampled_from([None, 0, 1, 2, 3, 4, 5, 6, 7, -1, "4"])


def plain() -> tuple[dict[str, Any], bytes]:
    return split_glb(mesh_glb(RIG.template, RIG.faces))


@bounded(100)
@given(COUNTS, COUNTS, st.integers(1, 120), MODES)
def test_primitives_nodes_and_depth(primitives: int, nodes: int, depth: int, mode: Any) -> None:
    document, binary = plain()
    one = dict(document["meshes"][0]["primitives"][0])
    document["accessors"][one["indices"]]["count"] = 30  # few triangles, often
    if mode is not None:
        one["mode"] = mode
    document["meshes"][0]["primitives"] = [one] * primitives
    chain: list[dict[str, Any]] = [{"children": [index + 1]} for index in range(depth - 1)]
    chain.append({"children": list(range(depth, depth + nodes))})
    document["nodes"] = [*chain, *({"mesh": 0} for _ in range(nodes))]
    document["scenes"] = [{"nodes": [0]}]
    refused_or_sound(pack_glb(json.dumps(document).encode(), binary), "glb")


@bounded(100)
@given(st.data())
def test_any_tree_or_tangle_of_nodes(source: st.DataObject) -> None:
    document, binary = plain()
    count = source.draw(st.integers(1, 12))
    place = st.one_of(st.integers(0, count), NUMBERS)
    values = st.lists(st.one_of(st.floats(width=32), st.integers(-3, 3)), min_size=2, max_size=17)
    node = st.fixed_dictionaries(
        {},
        optional={
            "children": st.lists(place, max_size=4),
            "mesh": st.sampled_from([0, 0, 0, 1, -1, None]),
            "matrix": values,
            "translation": values,
            "rotation": values,
            "scale": values,
            "skin": NUMBERS,
            "camera": NUMBERS,
            "weights": values,
        },
    )
    document["nodes"] = source.draw(st.lists(node, min_size=count, max_size=count))
    document["scenes"] = [{"nodes": source.draw(st.lists(place, max_size=5))}]
    document["scene"] = source.draw(st.sampled_from([0, 0, 0, 1, None]))
    refused_or_sound(pack_glb(json.dumps(document).encode(), binary), "glb")


@bounded(150)
@given(st.data())
def test_sparse_arrays(source: st.DataObject) -> None:
    """Right ones and wrong ones, over numbers or over nothing, of positions and of corners."""
    document, binary = plain()
    primitive = document["meshes"][0]["primitives"][0]
    which = source.draw(st.sampled_from([primitive["attributes"]["POSITION"], primitive["indices"]]))
    accessor = document["accessors"][which]
    rows = source.draw(st.lists(st.integers(0, 400), max_size=30))
    kind = source.draw(st.sampled_from([5121, 5123, 5125]))
    width = {5121: "<u1", 5123: "<u2", 5125: "<u4"}[kind]
    places = np.array(rows, "<u4").astype(width).tobytes()
    places += b"\0" * (-len(places) % 4)
    values = source.draw(st.binary(max_size=400))
    start = document["buffers"][0]["byteLength"]
    document["bufferViews"] += [
        {"buffer": 0, "byteOffset": start, "byteLength": len(places)},
        {"buffer": 0, "byteOffset": start + len(places), "byteLength": len(values)},
    ]
    views = len(document["bufferViews"])
    accessor["sparse"] = {
        "count": source.draw(st.one_of(st.just(len(rows)), NUMBERS)),
        "indices": {"bufferView": source.draw(st.one_of(st.just(views - 2), NUMBERS)), "componentType": kind},
        "values": {"bufferView": source.draw(st.one_of(st.just(views - 1), NUMBERS))},
    }
    if source.draw(st.booleans()):
        accessor.pop("bufferView")
    refused_or_sound(pack_glb(json.dumps(document).encode(), binary + places + values), "glb")
