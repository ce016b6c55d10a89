"""A damaged model is refused with a sentence or read as a sound rig, whatever the damage."""

import json
import os
import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.damage import BOUNDED, damage, damaged
from helpers.fuzz_table import count
from helpers.toy_rig import toy_rig
from hypothesis import given
from hypothesis import strategies as st

from breastrig.core.errors import BadModel
from breastrig.core.glb import pack_glb, split_glb
from breastrig.gltf.read_rig import read_rig
from breastrig_studies.output.rig_files import write_rig

FILES = ("toy.glb", "toy.json", "drawings/lumpectomy.json")
NONSENSE = [None, True, -1, 0, 3, 2**40, 1e300, "", "pelvis", [], [0], {}, float("nan")]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("rig")
    write_rig(toy_rig(), folder)
    return folder


def refused_or_sound(folder: Path, name: str, content: bytes) -> None:
    kept = (folder / name).read_bytes()
    (folder / name).write_bytes(content)
    refused = rig = None
    try:
        rig = read_rig(folder / "toy.glb")
    except BadModel as error:
        refused = str(error)
    finally:
        (folder / name).write_bytes(kept)
    count(f"model {name}", "read" if refused is None else "refused")
    if refused is not None:
        assert refused.endswith(".")
        assert "\n" not in refused
        return
    vertices = len(rig.template)
    assert rig.faces.max() < vertices
    assert rig.skin_weights.shape == (vertices, len(rig.bones))
    assert rig.blendshapes.shape == (len(rig.shapes), vertices, 3)
    assert np.isfinite(rig.template).all()
    assert all(landmark.face < len(rig.faces) for landmark in rig.landmarks)


def test_a_model_that_is_no_ordinary_file_is_not_waited_for(folder: Path, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.glb")
    (tmp_path / "folder.glb").mkdir()
    for path in (tmp_path / "pipe.glb", tmp_path / "folder.glb", tmp_path / ("x" * 5000), Path("/dev/zero")):
        with pytest.raises(BadModel, match=r"cannot be read; .*\.$") as caught:
            read_rig(path)
        assert len(str(caught.value)) < 300


def sparse_target(document: dict[str, Any], source: st.DataObject) -> None:
    """Makes the first shape's or the mesh's positions a sparse array of any numbers."""
    numbers = st.one_of(st.integers(-2, 400), st.sampled_from([2**31, 2**40, -1, None, 1.5, "1"]))
    primitive = document["meshes"][0]["primitives"][0]
    place = source.draw(st.sampled_from([primitive["attributes"]["POSITION"], primitive["targets"][0]["POSITION"]]))
    accessor = document["accessors"][place]
    accessor["sparse"] = {
        "count": source.draw(numbers),
        "indices": {
            "bufferView": source.draw(st.integers(0, len(document["bufferViews"]))),
            "componentType": source.draw(st.sampled_from([5121, 5123, 5125, 5126, 0])),
            "byteOffset": source.draw(numbers),
        },
        "values": {"bufferView": source.draw(st.integers(0, len(document["bufferViews"])))},
    }
    if source.draw(st.booleans()):
        accessor.pop("bufferView", None)


@BOUNDED
@given(st.data())
def test_sparse_shapes(folder: Path, source: st.DataObject) -> None:
    document, binary = split_glb((folder / "toy.glb").read_bytes())
    sparse_target(document, source)
    refused_or_sound(folder, "toy.glb", pack_glb(json.dumps(document).encode(), binary))


@pytest.mark.parametrize("name", FILES)
def test_damaged_bytes(folder: Path, name: str) -> None:
    data = (folder / name).read_bytes()

    @BOUNDED
    @given(damage(len(data), header=8000))
    def run(edits: list[tuple[str, int, bytes]]) -> None:
        refused_or_sound(folder, name, damaged(data, edits))

    run()


@pytest.mark.parametrize("name", FILES)
def test_nonsense_at_any_place_of_the_json(folder: Path, name: str) -> None:
    data = (folder / name).read_bytes()
    text = json.dumps(split_glb(data)[0] if name.endswith(".glb") else json.loads(data))
    binary = split_glb(data)[1] if name.endswith(".glb") else b""

    @BOUNDED
    @given(st.integers(0, 2**32), st.sampled_from(NONSENSE))
    def run(seed: int, value: object) -> None:
        document = json.loads(text)
        place, choose = document, random.Random(seed)
        while True:
            keys = list(place) if isinstance(place, dict) else range(len(place))
            key = choose.choice(keys)
            if not (isinstance(place[key], dict | list) and place[key]) or choose.random() < 0.2:
                break
            place = place[key]
        place[key] = value
        changed = json.dumps(document).encode()
        refused_or_sound(folder, name, pack_glb(changed, binary) if name.endswith(".glb") else changed)

    run()
