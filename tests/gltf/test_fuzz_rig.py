"""A damaged model is refused with a sentence or read as a sound rig, whatever the damage."""

import json
import random
from pathlib import Path

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
from breastrig.gltf.write_rig import write_rig

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
    assert rig is not None
    vertices = len(rig.template)
    assert rig.faces.max() < vertices
    assert rig.skin_weights.shape == (vertices, len(rig.bones))
    assert rig.blendshapes.shape == (len(rig.shapes), vertices, 3)
    assert np.isfinite(rig.template).all()
    assert all(landmark.face < len(rig.faces) for landmark in rig.landmarks)


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
