"""A rig written is the rig read back, byte for byte and number for number, ours or anybody's."""

import base64
import json
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.toy_rig import toy_rig

from breastrig.cli.main import main
from breastrig.core.errors import BadModel
from breastrig.core.glb import pack_glb, split_glb
from breastrig.geometry.rotations import exp_so3
from breastrig.gltf import container
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.gltf.write_rig import rig_glb
from breastrig.rig.model import Rig
from breastrig_studies.output.rig_files import write_rig

FLOAT32 = 2.0**-24  # relative rounding of a float32


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_rig(toy_rig(), tmp_path, provenance={"source": "made in memory"})
    return tmp_path


def equal(first: Any, second: Any, tolerance: float = 0.0) -> bool:
    """Equal to the last field of the last bone, arrays within `tolerance`."""
    if isinstance(first, np.ndarray):
        return first.shape == second.shape and bool((np.abs(first - second) <= tolerance).all())
    if isinstance(first, tuple):
        return len(first) == len(second) and all(equal(a, b, tolerance) for a, b in zip(first, second, strict=True))
    if isinstance(first, dict):
        return list(first) == list(second) and all(equal(first[key], second[key], tolerance) for key in first)
    if hasattr(first, "__dataclass_fields__"):
        return all(
            equal(getattr(first, field.name), getattr(second, field.name), tolerance)
            for field in fields(first)
            if field.name not in ("sha256", "known")  # what is estimated for a rig is bound to its own file
        )
    return bool(first == second)


def test_what_was_written_is_read_back_to_float32(folder: Path) -> None:
    rig = read_rig(folder / "toy.glb")
    assert equal(rig, toy_rig(), tolerance=2 * FLOAT32)
    np.testing.assert_allclose(rig.skin_weights.sum(axis=1), 1.0, atol=0)
    np.testing.assert_array_equal(rig.template[rig.mirror_vertices] * [-1, 1, 1], rig.template)


def test_limits_landmarks_and_drawings_come_back_exactly(folder: Path) -> None:
    rig = read_rig(folder / "toy.glb")
    for field in ("joints", "shapes", "landmarks", "drawings", "regions", "mirror_vertices", "faces"):
        assert equal(getattr(rig, field), getattr(toy_rig(), field)), field


def test_the_same_rig_gives_the_same_bytes(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    again = tmp_path_factory.mktemp("again")
    write_rig(toy_rig(), again, provenance={"source": "made in memory"})
    files = sorted(path.relative_to(folder) for path in folder.rglob("*.*"))
    assert [str(path) for path in files] == ["drawings/lumpectomy.json", "toy.glb", "toy.json"]
    assert all((folder / path).read_bytes() == (again / path).read_bytes() for path in files)


def test_writing_what_was_read_gives_the_same_mesh(folder: Path) -> None:
    assert rig_glb(read_rig(folder / "toy.glb")) == (folder / "toy.glb").read_bytes()


def test_the_bytes_do_not_hang_on_the_version_of_the_program(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(container, "GENERATOR", "BreastRig 99.0.0")
    assert rig_glb(toy_rig()) == (folder / "toy.glb").read_bytes()


def test_the_hash_covers_mesh_side_file_and_drawings(folder: Path) -> None:
    hashes = {read_rig(folder / "toy.glb").sha256}
    for name in ("toy.json", "drawings/lumpectomy.json"):
        (folder / name).write_bytes((folder / name).read_bytes() + b"\n")
        hashes.add(read_rig(folder / "toy.glb").sha256)
    assert len(hashes) == 3
    assert all(len(value) == 64 for value in hashes)


def test_the_files_are_named_and_laid_out_as_the_contract_says(folder: Path) -> None:
    document, binary = split_glb((folder / "toy.glb").read_bytes())
    nodes = {node["name"]: node for node in document["nodes"]}
    assert set(nodes) == {"toy"} | {name + end for name in toy_rig().bone_names for end in ("", "_scale")}
    assert "weights" not in document["meshes"][0]
    assert nodes["toy"]["weights"] == [0.0] * 4
    assert document["meshes"][0]["extras"]["targetNames"] == ["bump_L", "bump_R", "wide", "flat"]
    primitive = document["meshes"][0]["primitives"][0]
    assert all(set(target) == {"POSITION", "NORMAL"} for target in primitive["targets"])
    for name in toy_rig().bone_names:
        assert set(nodes[name]) == {"name", "translation", "rotation", "children"}
        assert set(nodes[f"{name}_scale"]) == {"name", "scale"}
    joints = [document["nodes"][joint]["name"] for joint in document["skins"][0]["joints"]]
    assert joints == [f"{name}_scale" for name in toy_rig().bone_names]
    assert document["materials"][0].get("doubleSided", False) is False
    assert document["asset"]["generator"] == "BreastRig"
    assert document["asset"]["extras"]["notice"].startswith("Research use only")
    assert len(document["buffers"]) == 1
    assert document["buffers"][0]["byteLength"] <= len(binary)
    side = json.loads((folder / "toy.json").read_bytes())
    assert side["schema"] == "breastrig/rig@1"
    assert side["provenance"] == {"source": "made in memory"}
    drawing = json.loads((folder / "drawings" / "lumpectomy.json").read_bytes())
    assert drawing["schema"] == "breastrig/drawing@1"
    assert set(drawing["shapes"][0]) == {"name", "label", "closed", "color", "surface_points"}


def test_a_new_drawing_is_a_new_file(folder: Path) -> None:
    drawing = json.loads((folder / "drawings" / "lumpectomy.json").read_bytes())
    (folder / "drawings" / "mine.json").write_text(json.dumps(drawing | {"name": "mine", "label": "My own"}))
    rig = read_rig(folder / "toy.glb")
    assert rig.drawing_names == ("lumpectomy", "mine")


def test_drawings_come_in_the_side_files_order_and_the_others_after_them_by_name(folder: Path) -> None:
    first, side = json.loads((folder / "drawings" / "lumpectomy.json").read_text()), folder / "toy.json"
    for name in ("anatomy", "zigzag", "crosses"):
        (folder / "drawings" / f"{name}.json").write_text(json.dumps(first | {"name": name}))
    assert read_rig(folder / "toy.glb").drawing_names == ("lumpectomy", "anatomy", "crosses", "zigzag")
    side.write_text(json.dumps(json.loads(side.read_text()) | {"drawings": ["zigzag", "sketch"]}))
    with pytest.raises(BadModel, match='drawing "sketch" that does not exist'):
        read_rig(folder / "toy.glb")


def test_a_rig_without_shapes_landmarks_or_drawings_is_a_rig_too(tmp_path: Path) -> None:
    rig = replace(
        toy_rig(), shapes=(), blendshapes=np.zeros((0, 204, 3)), landmarks=(), drawings=(), joints=(), lengths=()
    )
    write_rig(rig, tmp_path)
    assert equal(read_rig(tmp_path / "toy.glb"), rig, tolerance=2 * FLOAT32)


def test_a_rig_cannot_be_written_when_gltf_cannot_hold_it(tmp_path: Path) -> None:
    rig = toy_rig()
    five = np.full((204, 5), 0.2)
    extra = replace(rig.bones[3], name="tail", parent=0, mirror="tail")
    with pytest.raises(BadModel, match="more than four bones"):
        write_rig(replace(rig, bones=(*rig.bones, extra), skin_weights=five), tmp_path)
    with pytest.raises(BadModel, match="exactly one bone without a parent"):
        write_rig(replace(rig, bones=(rig.bones[0], replace(rig.bones[1], parent=None), *rig.bones[2:])), tmp_path)
    with pytest.raises(BadModel, match="must all differ"):
        write_rig(replace(rig, name="chest"), tmp_path)


# rigs of other makers


def rewritten(folder: Path, change: Callable[[dict[str, Any]], None]) -> Rig:
    path = folder / "toy.glb"
    document, binary = split_glb(path.read_bytes())
    change(document)
    path.write_bytes(pack_glb(json.dumps(document).encode(), binary))
    return read_rig(path)


def joints_without_scale_nodes(document: dict[str, Any]) -> None:
    """As Blender writes it: the bones themselves are the joints."""
    parents = {child: index for index, node in enumerate(document["nodes"]) for child in node.get("children", [])}
    document["skins"][0]["joints"] = [parents[joint] for joint in document["skins"][0]["joints"]]


def flat_bones(document: dict[str, Any]) -> None:
    """All bones side by side, no hierarchy."""
    joints_without_scale_nodes(document)
    for node in document["nodes"]:
        node.pop("children", None)


def joints_in_another_order(document: dict[str, Any]) -> None:
    """Joint and inverse bind matrix keep together only if the accessor is reordered too, so swap equal ones: none."""
    joints_without_scale_nodes(document)
    document["nodes"].append({"name": "armature", "children": [0, 1]})
    document["scenes"][0]["nodes"] = [len(document["nodes"]) - 1]


def other_pose(document: dict[str, Any]) -> None:
    """Saved while posed: the rest frames are in the inverse bind matrices, not in the nodes."""
    for node in document["nodes"]:
        if "rotation" in node:
            node["rotation"], node["translation"] = [0.0, 0.6, 0.0, 0.8], [1.0, 2.0, 3.0]


def data_uri(document: dict[str, Any]) -> None:
    """A second, self-contained buffer does not disturb."""
    document["buffers"].append(
        {"byteLength": 4, "uri": "data:application/octet-stream;base64," + base64.b64encode(b"abcd").decode()}
    )


@pytest.mark.parametrize(
    "change", [joints_without_scale_nodes, flat_bones, joints_in_another_order, other_pose, data_uri]
)
def test_other_makers_files_are_read_as_the_same_rig(folder: Path, change: Callable[[dict[str, Any]], None]) -> None:
    assert equal(rewritten(folder, change), toy_rig(), tolerance=2 * FLOAT32)


def test_the_order_of_shapes_is_the_meshs_and_facts_follow_by_name(folder: Path) -> None:
    side = json.loads((folder / "toy.json").read_bytes())
    side["shapes"].reverse()
    (folder / "toy.json").write_text(json.dumps(side))
    assert equal(read_rig(folder / "toy.glb"), toy_rig(), tolerance=2 * FLOAT32)


def test_the_order_of_bones_is_the_side_files_and_weights_follow_by_name(folder: Path) -> None:
    side = json.loads((folder / "toy.json").read_bytes())
    side["bones"] = [side["bones"][i] for i in (0, 1, 3, 2)]
    (folder / "toy.json").write_text(json.dumps(side))
    rig = read_rig(folder / "toy.glb")
    assert rig.bone_names == ("pelvis", "chest", "shoulder_R", "shoulder_L")
    assert np.abs(rig.skin_weights - toy_rig().skin_weights[:, [0, 1, 3, 2]]).max() < 2 * FLOAT32
    assert np.abs(rig.bones[2].origin - toy_rig().bones[3].origin).max() < 1e-7
    assert rig.joints[1].child == 3


def test_turned_rest_frames_are_read_as_exact_rotations(tmp_path: Path) -> None:
    rig = toy_rig()
    turned = tuple(replace(bone, rotation=exp_so3(np.array([1.0, -2.0, i]))) for i, bone in enumerate(rig.bones))
    write_rig(replace(rig, bones=turned), tmp_path)
    found = read_rig(tmp_path / "toy.glb").rest_rotations
    np.testing.assert_allclose(found @ found.transpose(0, 2, 1), np.tile(np.eye(3), (4, 1, 1)), atol=1e-15)
    np.testing.assert_allclose(found, [bone.rotation for bone in turned], atol=1e-7)


# files that are wrong


def side(change: Callable[[dict[str, Any]], object]) -> Callable[[Path], None]:
    def apply(folder: Path) -> None:
        document = json.loads((folder / "toy.json").read_bytes())
        change(document)
        (folder / "toy.json").write_text(json.dumps(document))

    return apply


def mesh(change: Callable[[dict[str, Any]], object]) -> Callable[[Path], None]:
    def apply(folder: Path) -> None:
        document, binary = split_glb((folder / "toy.glb").read_bytes())
        change(document)
        (folder / "toy.glb").write_bytes(pack_glb(json.dumps(document).encode(), binary))

    return apply


def drawing(change: Callable[[dict[str, Any]], object]) -> Callable[[Path], None]:
    def apply(folder: Path) -> None:
        path = folder / "drawings" / "lumpectomy.json"
        document = json.loads(path.read_bytes())
        change(document)
        path.write_text(json.dumps(document))

    return apply


def primitive(document: dict[str, Any]) -> dict[str, Any]:
    return document["meshes"][0]["primitives"][0]


def twice(folder: Path) -> None:
    (folder / "drawings" / "copy.json").write_bytes((folder / "drawings" / "lumpectomy.json").read_bytes())


def quantised(document: dict[str, Any]) -> None:
    """As gltfpack leaves it: positions of 16 bits, of which the bind matrices make metres."""
    document["extensionsRequired"] = ["KHR_mesh_quantization"]
    position = document["meshes"][0]["primitives"][0]["attributes"]["POSITION"]
    document["accessors"][position] |= {"componentType": 5123, "normalized": True}


def many_shapes(document: dict[str, Any], count: int) -> None:
    """All of them one accessor, as a small file can have it."""
    mesh = document["meshes"][0]
    mesh["primitives"][0]["targets"] = mesh["primitives"][0]["targets"][:1] * count
    mesh["extras"]["targetNames"] = [f"s{number}" for number in range(count)]


def many_bones(document: dict[str, Any], count: int) -> None:
    first = len(document["nodes"])
    document["nodes"] += [{"name": f"b{number}"} for number in range(count)]
    document["skins"][0]["joints"] += list(range(first, first + count))


WRONG: list[tuple[Callable[[Path], object], str]] = [
    (lambda f: (f / "toy.glb").unlink(), "toy.glb cannot be read"),
    (lambda f: (f / "toy.json").unlink(), "toy.json cannot be read"),
    (lambda f: (f / "toy.json").write_text("{"), "not a JSON file"),
    (lambda f: (f / "toy.json").write_text("[" * 100_000), "not a JSON file"),
    (lambda f: (f / "toy.json").write_bytes(b"\xff\xfe"), "not a JSON file"),
    (lambda f: (f / "toy.glb").write_bytes(b""), "does not begin like a binary glTF"),
    (lambda f: (f / "toy.glb").write_bytes((f / "toy.glb").read_bytes()[:5000]), "cut off"),
    (side(lambda d: d.update(schema="breastrig/rig@9")), "schema"),
    (side(lambda d: d.pop("bones")), "bones"),
    (side(lambda d: d["bones"][0].update(name="hip.L")), "bones.0.name"),
    (side(lambda d: d["bones"][0].update(scale_min=[1, 2])), "bones.0.scale_min"),
    (side(lambda d: d["bones"][0].update(scale_min=[2, 2, 2])), "wrong way round"),
    (side(lambda d: d["bones"][0].update(scale_min=[0, 1, 1])), "bones.0.scale_min"),
    (side(lambda d: d["bones"].insert(0, d["bones"].pop(1))), "list parents first"),
    (side(lambda d: d["bones"][1].update(parent="tail")), '"tail" that does not exist'),
    (side(lambda d: d["bones"][1].update(name="pelvis")), "names must be unique"),
    (side(lambda d: d["bones"][3].update(name="tail")), '"tail", which the .glb does not have'),
    (side(lambda d: d["bones"].pop()), 'the bone "shoulder_R", which the side file does not list'),
    (side(lambda d: d["joints"][0].update(child="tail")), '"tail" that does not exist'),
    (side(lambda d: d["joints"][0].update(anchor=[0, float("nan"), 0])), "joints.0.anchor"),
    (side(lambda d: d["shapes"][0].update(name="other")), '"other", which the .glb does not have'),
    (side(lambda d: d["shapes"].pop()), 'the shape "flat", which the side file does not list'),
    (side(lambda d: d["shapes"][0].update(min=3)), "wrong way round"),
    (side(lambda d: d["shapes"][0].update(mirror="none")), '"none" that does not exist'),
    (side(lambda d: d["shapes"][0].update(kind="hard")), "shapes.0.kind"),
    (side(lambda d: d["landmarks"][0].update(face=9999)), "triangle 9999"),
    (side(lambda d: d["landmarks"][0].update(barycentric=[1, 1, 1])), "outside its triangle"),
    (side(lambda d: d["landmarks"][0].update(barycentric=[3, -1, -1])), "outside its triangle"),
    (side(lambda d: d["landmarks"][0].update(mirror="nose")), '"nose" that does not exist'),
    (side(lambda d: d["landmarks"][1].update(name="nipple_R")), "names must be unique"),
    (side(lambda d: d["symmetry"]["vertices"].pop()), "203 entries"),
    (side(lambda d: d["symmetry"]["vertices"].__setitem__(0, 9999)), "vertices that the mesh does not have"),
    (side(lambda d: d["regions"].update(breast_L=[9999])), "region breast_L"),
    (drawing(lambda d: d["shapes"][0]["surface_points"][0].update(face=9999)), "triangle 9999"),
    (drawing(lambda d: d["shapes"][0].update(color="red")), "shapes.0.color"),
    (drawing(lambda d: d["shapes"].append(d["shapes"][0])), "names must be unique"),
    (twice, "names must be unique"),
    (mesh(lambda d: d["nodes"][0].pop("skin")), "exactly one mesh with a skin"),
    (mesh(lambda d: d.pop("meshes")), "index of meshes"),
    (mesh(lambda d: d["meshes"][0]["primitives"].append(primitive(d))), "exactly one"),
    (mesh(lambda d: primitive(d).update(mode=1)), "not made of triangles"),
    (mesh(lambda d: primitive(d)["attributes"].update(JOINTS_1=3)), "more than four bones"),
    (mesh(lambda d: primitive(d)["attributes"].pop("JOINTS_0")), "structure is broken"),
    (mesh(lambda d: primitive(d)["attributes"].update(WEIGHTS_0=0)), "skin weights"),
    (mesh(lambda d: d["meshes"][0].pop("extras")), "4 shapes but 0 names"),
    (mesh(lambda d: d["meshes"][0]["extras"]["targetNames"].append("more")), "4 shapes but 5 names"),
    (mesh(lambda d: d["skins"][0]["joints"].pop()), "bones"),
    (mesh(lambda d: d["skins"][0].update(joints=[2, 2, 2, 2])), "same name"),
    (mesh(lambda d: d["accessors"][0].update(count=10**9)), "too large"),
    (mesh(lambda d: d["accessors"][0].update(count=10**6)), "beyond the end"),
    (mesh(lambda d: d["accessors"][0].update(type="VEC2")), "positions"),
    (mesh(lambda d: d["buffers"][0].update(uri="torso.bin")), "another file"),
    (mesh(lambda d: d["bufferViews"][0].update(byteOffset=-4)), "offset"),
    (mesh(lambda d: d.update(nodes=7)), "structure is broken"),
    (mesh(lambda d: d.update(extensionsUsed=["KHR_draco_mesh_compression"])), "compressed with Draco; export it again"),
    (mesh(lambda d: d.update(extensionsRequired=["EXT_meshopt_compression"])), "meshopt; export it again without"),
    (mesh(lambda d: d.update(extensionsRequired=["KHR_meshopt_compression"])), "meshopt; export it again without"),
    (mesh(lambda d: d.update(extensionsRequired=["VENDOR_packed"])), "glTF extension VENDOR_packed, which is not read"),
    (mesh(lambda d: quantised(d)), "quantised (KHR_mesh_quantization); export it again with 32-bit floats"),
    (mesh(lambda d: many_shapes(d, 22_000)), "22000 shapes, at most 1000"),
    (mesh(lambda d: many_bones(d, 300)), "at most 255 can be fitted"),
]


@pytest.mark.parametrize(("change", "words"), WRONG, ids=[words for _, words in WRONG])
def test_a_wrong_file_is_refused_with_one_sentence(folder: Path, change: Callable[[Path], object], words: str) -> None:
    change(folder)
    with pytest.raises(BadModel) as caught:
        read_rig(folder / "toy.glb")
    text = str(caught.value)
    assert words in text
    assert "\n" not in text
    assert text.endswith(".")
    assert str(folder) not in text


def test_a_rest_frame_with_a_scale_is_refused(folder: Path) -> None:
    document, binary = split_glb((folder / "toy.glb").read_bytes())
    accessor = document["accessors"][document["skins"][0]["inverseBindMatrices"]]
    start = document["bufferViews"][accessor["bufferView"]]["byteOffset"]
    scaled = np.frombuffer(binary, np.float32, 64, start) * np.float32(100.0)
    data = binary[:start] + scaled.tobytes() + binary[start + 256 :]
    (folder / "toy.glb").write_bytes(pack_glb(json.dumps(document).encode(), data))
    with pytest.raises(BadModel, match="scaled or mirrored; apply the armature's scale"):
        read_rig(folder / "toy.glb")


def test_numbers_that_are_not_finite_are_refused(folder: Path) -> None:
    document, binary = split_glb((folder / "toy.glb").read_bytes())
    data = np.array([np.nan], np.float32).tobytes() + binary[4:]
    (folder / "toy.glb").write_bytes(pack_glb(json.dumps(document).encode(), data))
    with pytest.raises(BadModel, match="not finite"):
        read_rig(folder / "toy.glb")


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_skin_weights_that_are_not_finite_are_refused_in_words(value: float, folder: Path) -> None:
    document, binary = split_glb((folder / "toy.glb").read_bytes())
    accessor = document["accessors"][document["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"]]
    start = document["bufferViews"][accessor["bufferView"]]["byteOffset"]
    data = binary[:start] + np.array([value], np.float32).tobytes() + binary[start + 4 :]
    (folder / "toy.glb").write_bytes(pack_glb(json.dumps(document).encode(), data))
    with pytest.raises(BadModel, match="skin weights contain numbers that are not finite; normalise"):
        read_rig(folder / "toy.glb")


def test_the_check_says_in_a_bad_line_what_cannot_be_read(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh(lambda d: d.update(extensionsRequired=["KHR_draco_mesh_compression"]))(folder)
    assert main(["model", "check", str(folder / "toy.glb")]) == 2
    said = capsys.readouterr()
    assert said.out.startswith("BAD the rig can be read: toy.glb cannot be used as a model: it is compressed")
    assert said.err == ""


def test_the_packaged_model_is_written_again_as_it_was_read(tmp_path: Path) -> None:
    rig = read_rig(default_rig_path())
    write_rig(rig, tmp_path)
    again = read_rig(tmp_path / "torso.glb")
    for field in (
        "template",
        "faces",
        "uv",
        "blendshapes",
        "skin_weights",
        "joints",
        "shapes",
        "landmarks",
        "drawings",
    ):
        assert equal(getattr(again, field), getattr(rig, field)), field
    assert equal(again, rig, tolerance=1e-7)  # rest frames are made exact rotations, which moves their last digit


def test_files_that_did_not_change_are_the_same_rig_and_changed_ones_are_another(folder: Path) -> None:
    first = read_rig(folder / "toy.glb")
    assert read_rig(folder / "toy.glb") is first
    drawing = folder / "drawings" / "lumpectomy.json"
    (folder / "drawings" / "zz.json").write_bytes(drawing.read_bytes().replace(b'"lumpectomy"', b'"another"'))
    more = read_rig(folder / "toy.glb")
    assert more.drawing_names == (*first.drawing_names, "another")
    (folder / "drawings" / "zz.json").unlink()
    assert read_rig(folder / "toy.glb").drawing_names == first.drawing_names
    (folder / "toy.json").unlink()
    with pytest.raises(BadModel):
        read_rig(folder / "toy.glb")
