"""Files whose outside is right and whose inside is not: what random bytes alone hardly ever reach."""

import json
from typing import Any

import numpy as np
import pytest
from helpers.damage import bounded, damage, damaged
from helpers.grid_files import meta_fields, meta_image, nrrd, nrrd_fields
from helpers.label_maps import body_labels, file_of, seg
from helpers.mr_image import mr_image
from helpers.refusals import is_sentence, refused_or_sound, sound_landmarks_or_refused
from helpers.scan_files import as_bytes, picture, textured_obj, tube, zipped
from helpers.structure_sets import ball, structures
from helpers.toy_rig import toy_rig
from hypothesis import given
from hypothesis import strategies as st

from breastrig.core.errors import BadInput
from breastrig.core.glb import pack_glb, split_glb
from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.scan.images.image import kept_image
from breastrig.scan.images.read_lesions import lesions_in
from breastrig.scan.volumes.answers import NOTHING_SAID

pytestmark = pytest.mark.long

NUMBERS = st.one_of(
    st.sampled_from(["0", "-1", "1", "2", "3", "204", "205", "4294967295", "-2147483649", "1e999", "nan", "inf", ""]),
    st.integers(-5, 300).map(str),
    st.floats().map(repr),
)
TOKEN = st.one_of(NUMBERS, st.text(max_size=6), st.sampled_from(["1/2/3", "1//1", "-1/-1", "/", "1/0", "#", "\\"]))
JSON = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(-(2**65), 2**65), st.floats(), st.text(max_size=8)),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.text(max_size=6), inner, max_size=3)),
    max_leaves=6,
)


def places(node: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """The paths of all values in a JSON document."""
    found = [path] if path else []
    inner = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, value in inner:
        found += places(value, (*path, key))
    return found


def with_other_values(document: Any, source: st.DataObject) -> bytes:
    """The JSON document with one to three values replaced or removed."""
    document = json.loads(json.dumps(document))
    for _ in range(source.draw(st.integers(1, 3))):
        *way, last = source.draw(st.sampled_from(places(document) or [("x",)]))
        node = document
        for step in way:
            node = node[step]
        if source.draw(st.booleans()) or not isinstance(node, dict):
            node[last] = source.draw(JSON)
        else:
            node.pop(last, None)
    return json.dumps(document).encode()


@bounded(250)
@given(st.sampled_from(["plain", "textured"]), st.data())
def test_a_glb_with_other_json(kind: str, source: st.DataObject) -> None:
    rig = toy_rig()
    data = (
        as_bytes(tube(), "glb") if kind == "plain" else mesh_glb(rig.template, rig.faces, uv=rig.uv, texture=picture())
    )
    document, binary = split_glb(data)
    refused_or_sound(pack_glb(with_other_values(document, source), binary), "glb")


@bounded(150)
@given(st.sampled_from(["model.obj", "model.mtl", "skin.jpg"]), st.data())
def test_a_zip_with_a_damaged_file_inside(name: str, source: st.DataObject) -> None:
    files = {**textured_obj(), "skin.jpg": picture()}
    files[name] = damaged(files[name], source.draw(damage(len(files[name]))))
    refused_or_sound(zipped(files), "zip")


@bounded(100)
@given(st.dictionaries(st.text(min_size=1, max_size=20), st.binary(max_size=60), max_size=5), st.booleans())
def test_a_zip_of_anything(files: dict[str, bytes], with_scan: bool) -> None:
    safe = {"_" + name.encode("utf-8", "replace").decode(): content for name, content in files.items()}
    refused_or_sound(zipped({**safe, **(textured_obj() if with_scan else {})}), "zip")


@bounded(200)
@given(
    st.lists(
        st.tuples(st.sampled_from(["v", "vt", "vn", "f", "l", "p", "g", "o", "usemtl"]), st.lists(TOKEN, max_size=5)),
        max_size=12,
    )
)
def test_an_obj_with_odd_lines(lines: list[tuple[str, list[str]]]) -> None:
    odd = "\n".join(" ".join([word, *tokens]) for word, tokens in lines).encode("utf-8", "replace")
    refused_or_sound(as_bytes(tube(), "obj") + b"\n" + odd, "obj")


PROPERTY = st.one_of(
    st.tuples(
        st.just("property"), st.sampled_from(["float", "double", "uchar", "int", "int64", "?"]), st.sampled_from("xyzr")
    ),
    st.tuples(
        st.just("property list"),
        st.sampled_from(["uchar", "char", "float", "uint"]),
        st.just("int"),
        st.just("vertex_indices"),
    ),
).map(" ".join)


@bounded(200)
@given(
    st.sampled_from(["ascii", "binary_little_endian", "binary_big_endian"]),
    st.lists(
        st.tuples(st.sampled_from(["vertex", "face", "edge"]), NUMBERS, st.lists(PROPERTY, max_size=5)), max_size=3
    ),
    st.binary(max_size=200),
)
def test_a_ply_with_an_odd_header(form: str, elements: list[tuple[str, str, list[str]]], body: bytes) -> None:
    lines = ["ply", f"format {form} 1.0"]
    for name, count, properties in elements:
        lines += [f"element {name} {count}", *properties]
    tail = as_bytes(tube(), "ply").split(b"end_header\n", 1)[1]
    refused_or_sound("\n".join([*lines, "end_header\n"]).encode() + body + tail, "ply")


@bounded(150)
@given(st.lists(st.lists(NUMBERS, min_size=2, max_size=4), min_size=1, max_size=6), st.integers(0, 384))
def test_an_ascii_stl_with_odd_vertices(vertices: list[list[str]], after: int) -> None:
    parts = as_bytes(tube(), "stl_ascii").decode().split("endfacet")
    loop = "\n".join(f"vertex {' '.join(numbers)}" for numbers in vertices)
    parts.insert(after, f"\nfacet normal 0 0 1\nouter loop\n{loop}\nendloop\n")
    refused_or_sound("endfacet".join(parts).encode(), "stl")


@bounded(100)
@given(st.integers(0, 2**32 - 1), st.lists(st.floats(width=32), min_size=12, max_size=48))
def test_a_binary_stl_with_odd_numbers(count: int, values: list[float]) -> None:
    data = bytearray(as_bytes(tube(), "stl"))
    with np.errstate(invalid="ignore"):
        odd = np.array(values, "<f4").tobytes()
    data[84 : 84 + len(odd)] = odd
    refused_or_sound(bytes(data), "stl")
    data[80:84] = count.to_bytes(4, "little")
    refused_or_sound(bytes(data), "stl")


POINTS = {
    "schema": "breastrig/landmarks@1",
    "unit": "mm",
    "landmarks": {"nipple_L": [1.0, 2.0, 3.0], "xiphoid": [0, 0, 9]},
}
SLICER = {
    "@schema": "https://raw.githubusercontent.com/slicer/slicer/master/markups-schema-v1.0.3.json#",
    "markups": [
        {
            "type": "Fiducial",
            "coordinateSystem": "LPS",
            "controlPoints": [
                {"id": "1", "label": "nipple_L", "position": [1.0, 2.0, 3.0], "positionStatus": "defined"}
            ],
        }
    ],
}


@bounded(200)
@given(st.sampled_from([POINTS, SLICER]), st.data())
def test_a_landmark_document_with_other_values(document: dict[str, Any], source: st.DataObject) -> None:
    sound_landmarks_or_refused(with_other_values(document, source))


@bounded(150)
@given(st.lists(st.lists(TOKEN, max_size=5), max_size=6), st.sampled_from([",", ";", "\t"]))
def test_a_landmark_table_of_anything(rows: list[list[str]], comma: str) -> None:
    text = "\n".join(["name,x,y,z", *(comma.join(row) for row in rows)])
    sound_landmarks_or_refused(text.encode("utf-8", "replace"))


@bounded(150)
@given(st.lists(st.dictionaries(st.sampled_from(["name", "x", "y", "z", "active"]), TOKEN), max_size=4), st.booleans())
def test_a_meshlab_file_of_anything(points: list[dict[str, str]], declared: bool) -> None:
    doctype = '<!DOCTYPE PickedPoints [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;&a;">]>' if declared else ""
    inner = "".join("<point " + " ".join(f'{key}="{value}"' for key, value in one.items()) + "/>" for one in points)
    sound_landmarks_or_refused(f"{doctype}<PickedPoints>{inner}</PickedPoints>".encode("utf-8", "replace"))


VALUES = st.one_of(
    NUMBERS,
    st.lists(NUMBERS, max_size=5).map(" ".join),
    st.sampled_from(
        ["(1,0,0) (0,1,0) (0,0,1)", "none none none", "(,,)", "RAI", "True", "LOCAL", "gzip", "raw", "float"]
    ),
    st.text(max_size=8),
)


@bounded(100)
@given(st.sampled_from(["nrrd", "mha"]), st.data())
def test_a_grid_with_odd_fields(kind: str, source: st.DataObject) -> None:
    labels = body_labels()[::4, ::4, ::4]
    fields = nrrd_fields(labels) if kind == "nrrd" else meta_fields(labels)
    for name in source.draw(st.lists(st.sampled_from(sorted(fields)), min_size=1, max_size=3)):
        fields[name] = source.draw(VALUES)
    words = {"Segment0_ID": "a", "Segment0_Layer": source.draw(VALUES), "Segment0_Tags": source.draw(VALUES)}
    refused_or_sound(nrrd(labels, fields, words) if kind == "nrrd" else meta_image(labels, fields), kind, "auto")


@bounded(60)
@given(st.sampled_from(["nrrd", "structures", "seg"]), st.data())
def test_a_damaged_file_of_lesions_is_refused_or_sound(kind: str, source: st.DataObject) -> None:
    shown = mr_image(step=6.0)
    on = kept_image(shown.image)
    labels = np.asfortranarray(shown.lesion.astype(np.uint8))
    data = {
        "nrrd": lambda: nrrd(labels, nrrd_fields(labels, shown.image.affine)),
        "structures": lambda: structures([ball(shown.lesion_at, 9.0, 3.0)]),
        "seg": lambda: file_of(seg({1: labels > 0})),
    }[kind]()
    lesions, refused = (), None
    try:
        lesions = lesions_in(damaged(data, source.draw(damage(len(data)))), on, NOTHING_SAID).lesions
    except BadInput as error:
        refused = error
    assert refused is None or is_sentence(refused)
    assert all(np.isfinite([*each.center, each.radius]).all() and each.radius > 0.0 for each in lesions)
