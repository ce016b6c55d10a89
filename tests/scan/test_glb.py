"""GLB scans: limits on what the JSON asks for, and geometry in every form that the format has."""

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from helpers.scan_files import picture
from helpers.toy_rig import toy_rig

import breastrig.scan.formats.gltf.glb as glb
from breastrig.core.errors import BadScan, TooLarge
from breastrig.core.glb import pack_glb, split_glb
from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.scan.limits import GLTF_DEPTH, GLTF_ENTRIES, GLTF_JSON_BYTES, GLTF_NODES, GLTF_PRIMITIVES
from breastrig.scan.read import read_scan
from breastrig.scan.scan import Scan

RIG = toy_rig()
Change = Callable[[dict[str, Any]], None]
POSITIONS, INDICES = 0, 2  # accessors of our own mesh_glb


def changed(change: Change, data: bytes | None = None, more: bytes = b"") -> bytes:
    document, binary = split_glb(mesh_glb(RIG.template, RIG.faces) if data is None else data)
    change(document)
    return pack_glb(json.dumps(document).encode(), binary + more)


def many_primitives(count: int) -> Change:
    def change(document: dict[str, Any]) -> None:
        document["meshes"][0]["primitives"] *= count

    return change


def bare_primitives(count: int) -> Change:
    def change(document: dict[str, Any]) -> None:
        document["meshes"][0]["primitives"] = [{"attributes": {"POSITION": 0}}] * count

    return change


def many_nodes(count: int, drawing: bool = True) -> Change:
    def change(document: dict[str, Any]) -> None:
        document["nodes"] = [{"mesh": 0}] + [{"mesh": 0} if drawing else {} for _ in range(count - 1)]
        document["scenes"] = [{"nodes": list(range(count))}]

    return change


def deep(count: int) -> Change:
    def change(document: dict[str, Any]) -> None:
        document["nodes"] = [{"children": [index + 1]} for index in range(count - 1)] + [{"mesh": 0}]
        document["scenes"] = [{"nodes": [0]}]

    return change


def many_entries(kind: str) -> Change:
    def change(document: dict[str, Any]) -> None:
        document[kind] = (document.get(kind) or [{}])[:1] * (GLTF_ENTRIES + 1)

    return change


def wide(document: dict[str, Any]) -> None:
    """Few nodes and few primitives, which multiply."""
    many_nodes(5000)(document)
    many_primitives(5000)(document)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (bare_primitives(300_000), "300,000 pieces"),
        (many_primitives(GLTF_PRIMITIVES + 1), "pieces"),
        (many_nodes(GLTF_PRIMITIVES + 1), "pieces"),
        (wide, "25,000,000 pieces"),
        (many_nodes(GLTF_NODES + 1, drawing=False), "nodes"),
        (deep(GLTF_DEPTH + 1), "nested"),
        (deep(GLTF_NODES), "nested"),
        *(
            (many_entries(kind), kind)
            for kind in ("meshes", "accessors", "bufferViews", "materials", "images", "textures")
        ),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_document_that_asks_for_too_much_is_refused_before_an_array_is_read(
    change: Change, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*_: object) -> None:
        raise AssertionError("an array was read before the document was checked")

    monkeypatch.setattr(glb, "GltfArrays", never)
    with pytest.raises(TooLarge, match=words):
        read_scan(changed(change))


def test_json_that_is_longer_than_any_scans_is_not_even_parsed(monkeypatch: pytest.MonkeyPatch) -> None:
    data = pack_glb(b'{"extras": "' + b" " * GLTF_JSON_BYTES + b'"}', b"")
    monkeypatch.setattr(glb, "split_glb", None)
    with pytest.raises(TooLarge, match="MB of text"):
        read_scan(data)


@pytest.mark.parametrize(
    "change", [many_primitives(200), many_nodes(200), deep(GLTF_DEPTH), many_nodes(200, drawing=False)]
)
def test_what_real_exporters_write_is_read(change: Change) -> None:
    assert len(read_scan(changed(change)).faces) % 384 == 0


def moved_rows(document: dict[str, Any], rows: np.ndarray, accessor: int, base: bool) -> bytes:
    """Makes an accessor sparse: `rows` move by 0.01 m (or get the numbers that zeros lack); the bytes to append."""
    values = (RIG.template[rows] + (0.01 if base else 0.0)).astype("<f4").tobytes()
    places = rows.astype("<u2").tobytes()
    places += b"\0" * (-len(places) % 4)
    start = document["buffers"][0]["byteLength"]
    views = document["bufferViews"]
    views += [
        {"buffer": 0, "byteOffset": start, "byteLength": len(places)},
        {"buffer": 0, "byteOffset": start + len(places), "byteLength": len(values)},
    ]
    document["buffers"][0]["byteLength"] += len(places) + len(values)
    document["accessors"][accessor]["sparse"] = {
        "count": len(rows),
        "indices": {"bufferView": len(views) - 2, "componentType": 5123},
        "values": {"bufferView": len(views) - 1},
    }
    if not base:
        del document["accessors"][accessor]["bufferView"]
    return places + values


def sparse(base: bool, rows: np.ndarray, accessor: int = POSITIONS) -> bytes:
    document, binary = split_glb(mesh_glb(RIG.template, RIG.faces))
    more = moved_rows(document, rows, accessor, base)
    return pack_glb(json.dumps(document).encode(), binary + more)


def test_sparse_positions_over_others_are_followed() -> None:
    rows = np.arange(0, len(RIG.template), 3)
    wanted = RIG.template.copy()
    wanted[rows] += 0.01
    np.testing.assert_allclose(read_scan(sparse(True, rows)).vertices, wanted, atol=1e-6)


def test_sparse_positions_over_zeros_are_followed() -> None:
    scan = read_scan(sparse(False, np.arange(len(RIG.template))))
    np.testing.assert_allclose(scan.vertices, RIG.template, atol=1e-6)


@pytest.mark.parametrize(
    "change",
    [
        lambda s: s.update(count=10**9),
        lambda s: s.update(count=-1),
        lambda s: s.pop("values"),
        lambda s: s["indices"].update(componentType=5126),
        lambda s: s["indices"].update(bufferView=10**6),
        lambda s: s["values"].update(byteOffset=10**9),
        lambda s: s["indices"].update(bufferView=0),
    ],
)
def test_a_sparse_array_that_is_wrong_is_one_sentence(change: Callable[[dict[str, Any]], Any]) -> None:
    data = sparse(True, np.arange(100))
    with pytest.raises(BadScan, match=r"^This GLB file cannot be read: .*\.$"):
        read_scan(changed(lambda d: change(d["accessors"][POSITIONS]["sparse"]), data))


def corners(scan: Scan) -> np.ndarray:
    """(F, 9) triangles from their smallest corner, sorted: the same for the same surface seen from the same side."""
    triangles = np.round(scan.vertices[scan.faces], 5) + 0.0
    first = np.array([np.lexsort(triangle.T[::-1])[0] for triangle in triangles])
    turned = np.stack([np.roll(triangle, -start, axis=0) for triangle, start in zip(triangles, first, strict=True)])
    rows = turned.reshape(len(turned), 9)
    return rows[np.lexsort(rows.T[::-1])]


@pytest.mark.parametrize("mode", ["strip", "fan", "corners"])
def test_triangles_in_another_form_are_the_same_triangles(mode: str) -> None:
    """Each triangle of the tube as a strip or a fan of its own, or all without indices."""
    vertices, faces = RIG.template, RIG.faces
    document, _ = split_glb(mesh_glb(vertices, faces))
    if mode == "corners":  # without indices
        binary = vertices[faces].astype("<f4").tobytes()
        primitives = [{"attributes": {"POSITION": 0}}]
        views = [{"buffer": 0, "byteLength": len(binary)}]
        accessors = [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": faces.size}]
    else:
        number, rows = {"strip": 5, "fan": 6}[mode], faces.astype("<u2")
        positions = vertices.astype("<f4").tobytes()
        binary = positions + rows.tobytes()
        views = [
            {"buffer": 0, "byteLength": len(positions)},
            {"buffer": 0, "byteOffset": len(positions), "byteLength": rows.nbytes},
        ]
        accessors = [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(vertices)}]
        accessors += [
            {"bufferView": 1, "byteOffset": 6 * index, "componentType": 5123, "type": "SCALAR", "count": 3}
            for index in range(len(rows))
        ]
        primitives = [
            {"attributes": {"POSITION": 0}, "indices": 1 + index, "mode": number} for index in range(len(rows))
        ]
    document |= {"bufferViews": views, "accessors": accessors, "buffers": [{"byteLength": len(binary)}]}
    document["meshes"] = [{"primitives": primitives}]
    scan = read_scan(pack_glb(json.dumps(document).encode(), binary))
    np.testing.assert_allclose(corners(scan), corners(read_scan(mesh_glb(vertices, faces))), atol=2e-5)


def test_long_strips_and_fans_turn_every_triangle_the_right_way() -> None:
    strip = glb._triangles(np.arange(6), 5)
    assert strip.tolist() == [[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5]]
    assert glb._triangles(np.arange(5), 6).tolist() == [[0, 1, 2], [0, 2, 3], [0, 3, 4]]
    assert len(glb._triangles(np.arange(2), 5)) == len(glb._triangles(np.arange(2), 6)) == 0


def test_nodes_below_nodes_turn_scale_and_move() -> None:
    half = float(np.sqrt(0.5))

    def place(document: dict[str, Any]) -> None:
        document["nodes"] = [
            {"translation": [1.0, 2.0, 3.0], "children": [1]},
            {"rotation": [0.0, 0.0, half, half], "scale": [2.0, 2.0, 2.0], "children": [2]},
            {"matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.5, 0, 0, 1], "mesh": 0, "camera": 0},
        ]
        document["scenes"] = [{"nodes": [0]}]

    scan = read_scan(changed(place), units="m")
    quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    wanted = 2.0 * (RIG.template + np.array([0.5, 0.0, 0.0])) @ quarter + np.array([1.0, 2.0, 3.0])
    np.testing.assert_allclose(scan.vertices, wanted, atol=1e-6)


def test_only_the_shown_scene_is_read() -> None:
    def two(document: dict[str, Any]) -> None:
        document["nodes"] = [{"mesh": 0}, {"mesh": 0, "translation": [5.0, 0.0, 0.0]}]
        document |= {"scenes": [{"nodes": [1]}, {"nodes": [0]}], "scene": 1}

    np.testing.assert_allclose(read_scan(changed(two)).vertices, RIG.template, atol=1e-6)


def test_a_file_without_scenes_shows_what_it_has() -> None:
    def none(document: dict[str, Any]) -> None:
        del document["scenes"], document["scene"]

    assert len(read_scan(changed(none)).faces) == len(RIG.faces)


def test_what_is_not_drawn_is_not_looked_at() -> None:
    def spare(document: dict[str, Any]) -> None:
        document["accessors"].append({"componentType": 9999, "type": "NONE", "count": 3})
        document["meshes"].append({"primitives": [{"attributes": {"POSITION": 3}}]})
        document |= {"animations": [{"channels": 3}], "cameras": 7, "extras": {"a": [1]}, "skins": None}

    assert len(read_scan(changed(spare)).faces) == len(RIG.faces)


HALF = len(RIG.template) // 2


def with_more(*arrays: np.ndarray, change: Callable[[dict[str, Any], list[int]], None]) -> bytes:
    """Our own mesh with further arrays in it, whose accessors `change` is told."""
    document, binary = split_glb(mesh_glb(RIG.template, RIG.faces))
    kinds = {"f4": 5126, "u1": 5121}
    numbers = []
    for values in arrays:
        binary += bytes(-len(binary) % 4)
        view = {"buffer": 0, "byteOffset": len(binary), "byteLength": values.nbytes}
        document["bufferViews"].append(view)
        shape = "MAT4" if values.ndim == 3 else f"VEC{values.shape[1]}"
        accessor = {"bufferView": len(document["bufferViews"]) - 1, "componentType": kinds[values.dtype.str[1:]]}
        document["accessors"].append(accessor | {"count": len(values), "type": shape})
        numbers.append(len(document["accessors"]) - 1)
        binary += (values.transpose(0, 2, 1) if values.ndim == 3 else values).tobytes()
    document["buffers"] = [{"byteLength": len(binary)}]
    change(document, numbers)
    return pack_glb(json.dumps(document).encode(), binary)


def with_skin(nodes: list[dict[str, Any]], binds: np.ndarray | None, weights: np.ndarray | None = None) -> bytes:
    """The lower half of the vertices on the first of the joints, which are the nodes 1 and 2, the others on the second.

    The mesh is on node 0.
    """
    joints = np.zeros((len(RIG.template), 4), "u1")
    joints[HALF:, 0] = 1
    shares = np.tile(np.array([[1.0, 0.0, 0.0, 0.0]], "f4"), (len(joints), 1)) if weights is None else weights

    def change(document: dict[str, Any], numbers: list[int]) -> None:
        primitive = document["meshes"][0]["primitives"][0]
        primitive["attributes"] |= {"JOINTS_0": numbers[0], "WEIGHTS_0": numbers[1]}
        skin = {"joints": [1, 2]} | ({"inverseBindMatrices": numbers[2]} if binds is not None else {})
        document |= {"skins": [skin], "nodes": nodes}
        inner = {child for node in nodes for child in node.get("children", [])}
        document["scenes"] = [{"nodes": [index for index in range(len(nodes)) if index not in inner]}]

    return with_more(joints, shares, *([] if binds is None else [binds]), change=change)


QUARTER = {"rotation": [0.5**0.5, 0.0, 0.0, 0.5**0.5], "scale": [0.01] * 3}  # Blender's armature of centimetres
UNDONE = np.diag([100.0, 100.0, 100.0, 1.0]) @ np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])


@pytest.mark.parametrize("own", [{}, {"scale": [3.0] * 3}, {"translation": [0.0, 9.0, 0.0]}, QUARTER])
def test_the_node_of_a_mesh_with_a_skin_does_not_move_it(own: dict[str, Any]) -> None:
    nodes = [{"mesh": 0, "skin": 0, **own}, {}, {}, {"children": [0, 1, 2], **QUARTER}]
    scan = read_scan(with_skin(nodes, np.stack([UNDONE, UNDONE]).astype("f4")))
    np.testing.assert_allclose(scan.vertices, RIG.template, atol=1e-5)
    assert scan.notes == ()


def test_joints_place_the_vertices_that_hang_on_them() -> None:
    nodes = [{"mesh": 0, "skin": 0}, {"translation": [0.5, 0, 0]}, {"translation": [0, 0, 0.25]}]
    wanted = RIG.template.copy()
    wanted[:HALF, 0] += 0.5
    wanted[HALF:, 2] += 0.25
    np.testing.assert_allclose(read_scan(with_skin(nodes, None)).vertices, wanted, atol=1e-6)
    weights = np.zeros((len(RIG.template), 4), "f4")  # none at all: they hang on the first
    weights[:HALF, 0], weights[HALF:, :2] = 3.0, 0.0  # which need not be normalised
    np.testing.assert_allclose(read_scan(with_skin(nodes, None, weights)).vertices, wanted, atol=1e-6)


def test_joints_that_mirror_turn_the_triangles() -> None:
    nodes = [{"mesh": 0, "skin": 0}, {"scale": [-1.0, 1.0, 1.0]}, {"scale": [-1.0, 1.0, 1.0]}]
    scan = read_scan(with_skin(nodes, None))
    np.testing.assert_allclose(scan.vertices, RIG.template * [-1.0, 1.0, 1.0], atol=1e-6)
    np.testing.assert_array_equal(scan.faces, RIG.faces[:, ::-1])


def test_a_skin_of_joints_that_are_not_there_is_refused() -> None:
    nodes = [{"mesh": 0, "skin": 0}, {}]
    with pytest.raises(BadScan, match="joint of it is in no scene"):
        read_scan(with_skin(nodes, None))
    with pytest.raises(BadScan, match="no inverse bind matrix"):
        read_scan(with_skin([*nodes, {}], UNDONE[None].astype("f4")))


def test_shapes_are_followed_as_far_as_the_file_sets_them() -> None:
    offsets = np.random.default_rng(1).normal(scale=0.01, size=(2, len(RIG.template), 3)).astype("f4")

    def change(document: dict[str, Any], numbers: list[int]) -> None:
        document["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": number} for number in numbers]
        document["meshes"][0]["weights"] = [1.0, 1.0]
        document["nodes"][0]["weights"] = [0.0, 0.5]

    scan = read_scan(with_more(*offsets, change=change))
    np.testing.assert_allclose(scan.vertices, RIG.template + 0.5 * offsets[1], atol=1e-6)
    assert scan.notes == ()


def test_shapes_count_as_vertices(monkeypatch: pytest.MonkeyPatch) -> None:
    def change(document: dict[str, Any], _: list[int]) -> None:
        document["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": POSITIONS}] * 40
        document["meshes"][0]["weights"] = [1.0] * 40

    monkeypatch.setattr(glb, "VERTICES", 30 * len(RIG.template))
    with pytest.raises(TooLarge, match="triangles allowed"):
        read_scan(with_more(change=change))


def test_a_texture_is_placed_by_the_coordinates_that_its_material_names() -> None:
    def second(document: dict[str, Any]) -> None:
        attributes = document["meshes"][0]["primitives"][0]["attributes"]
        attributes["TEXCOORD_1"] = attributes.pop("TEXCOORD_0")
        document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 1

    scan = read_scan(changed(second, mesh_glb(RIG.template, RIG.faces, uv=RIG.uv, texture=picture())))
    assert scan.uv is not None
    np.testing.assert_allclose(scan.uv, RIG.uv, atol=1e-6)
