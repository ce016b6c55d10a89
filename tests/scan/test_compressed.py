"""Compressed and nested scans outside the page: by what `breastrig[formats]` brings, or one sentence on what to do."""

import sys

import numpy as np
import pytest
from helpers.draco_scan import draco_glb
from helpers.scan_files import picture
from helpers.toy_rig import toy_rig

from breastrig.core.errors import BadScan
from breastrig.core.glb import pack_glb, split_glb
from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.scan.read import read_scan

RIG = toy_rig()
STEP = 2.0 * np.abs(RIG.template).max() / 2**16  # of the places that the tests' Draco files can say


def by_place(vertices: np.ndarray, *more: np.ndarray) -> np.ndarray:
    """(V, ...) sorted rows: Draco numbers its points anew."""
    rows = np.column_stack([np.round(vertices, 3), *more])
    return rows[np.lexsort(rows[:, :3].T)]


def test_a_glb_that_draco_compressed_has_the_triangles_colours_and_picture_of_the_plain_one() -> None:
    linear = np.random.default_rng(2).integers(0, 256, (len(RIG.template), 3)).astype(np.uint8)
    plain = read_scan(mesh_glb(RIG.template, RIG.faces, uv=RIG.uv, texture=picture()))
    upper_left = np.column_stack([RIG.uv[:, 0], 1.0 - RIG.uv[:, 1]])
    scan = read_scan(draco_glb(RIG.template, RIG.faces, uv=upper_left, texture=picture()))
    assert scan.picture == plain.picture
    assert scan.uv is not None
    assert plain.uv is not None
    corners = [np.concatenate([one.vertices[one.faces], one.uv[one.faces]], axis=2) for one in (scan, plain)]
    middles = [np.round(each.mean(axis=1), 3) for each in corners]
    orders = [np.lexsort(each.T) for each in middles]
    np.testing.assert_allclose(middles[0][orders[0]], middles[1][orders[1]], atol=1.1e-3)
    coloured = read_scan(draco_glb(RIG.template, RIG.faces, colours=linear))
    assert coloured.colours is not None
    assert len(coloured.vertices) == len(RIG.template)
    nearest = np.linalg.norm(coloured.vertices[:, None] - RIG.template[None], axis=2).argmin(axis=1)
    light = linear[nearest] / 255.0
    srgb = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1.0 / 2.4) - 0.055)
    np.testing.assert_array_equal(coloured.colours, np.round(255.0 * srgb))
    np.testing.assert_allclose(coloured.vertices, RIG.template[nearest], atol=STEP)


def test_without_the_decoder_one_sentence_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    data = draco_glb(RIG.template, RIG.faces)
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    with pytest.raises(BadScan, match=r'\(Draco\); open it in the page, .* install "breastrig\[formats\]"'):
        read_scan(data)


def test_damaged_draco_data_is_one_sentence() -> None:
    document, binary = split_glb(draco_glb(RIG.template, RIG.faces))
    import json

    text = json.dumps(document).encode()
    for broken in (binary[:40], bytes(len(binary)), binary[: len(binary) // 2]):
        with pytest.raises(BadScan, match=r"\.$"):
            read_scan(pack_glb(text, broken + bytes(len(binary) - len(broken))))
