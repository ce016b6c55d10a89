"""Accessors as other exporters write them: interleaved, sparse, normalised, in data addresses."""

import base64
import struct
from typing import Any

import numpy as np
import pytest

from breastrig.core.gltf_arrays import GltfArrays


def arrays(binary: bytes, views: list[dict[str, Any]], accessors: list[dict[str, Any]]) -> GltfArrays:
    document = {"buffers": [{"byteLength": len(binary)}], "bufferViews": views, "accessors": accessors}
    return GltfArrays(document, binary)


def test_interleaved_arrays_are_taken_apart() -> None:
    binary = struct.pack("<3f2H3f2H", 1, 2, 3, 10, 11, 4, 5, 6, 12, 13)
    views = [{"buffer": 0, "byteLength": 32, "byteStride": 16}]
    found = arrays(
        binary,
        views,
        [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 2},
            {"bufferView": 0, "byteOffset": 12, "componentType": 5123, "type": "VEC2", "count": 2},
        ],
    )
    np.testing.assert_array_equal(found.read(0), [[1, 2, 3], [4, 5, 6]])
    np.testing.assert_array_equal(found.read(1), [[10, 11], [12, 13]])


def test_a_sparse_array_changes_some_rows_of_zeros_or_of_another() -> None:
    binary = struct.pack("<2H3f3f", 1, 3, 7, 8, 9, 4, 5, 6)
    views = [{"buffer": 0, "byteLength": 4}, {"buffer": 0, "byteOffset": 4, "byteLength": 24}]
    sparse = {"count": 2, "indices": {"bufferView": 0, "componentType": 5123}, "values": {"bufferView": 1}}
    accessor = {"componentType": 5126, "type": "VEC3", "count": 4, "sparse": sparse}
    found = arrays(binary, views, [accessor, {**accessor, "count": 3}, {**accessor, "bufferView": 1, "count": 2}])
    np.testing.assert_array_equal(found.read(0), [[0, 0, 0], [7, 8, 9], [0, 0, 0], [4, 5, 6]])
    for index in (1, 2):
        with pytest.raises(ValueError, match="beyond its end"):
            found.read(index)


def test_normalised_integers_become_numbers_between_minus_one_and_one() -> None:
    binary = bytes([0, 255, 51, 102]) + struct.pack("<4b", -128, -127, 0, 127)
    views = [{"buffer": 0, "byteLength": 8}]
    accessor = {"bufferView": 0, "type": "VEC4", "count": 1, "normalized": True}
    found = arrays(
        binary, views, [{**accessor, "componentType": 5121}, {**accessor, "byteOffset": 4, "componentType": 5120}]
    )
    np.testing.assert_allclose(found.read(0), [[0, 1, 0.2, 0.4]])
    np.testing.assert_allclose(found.read(1), [[-1, -1, 0, 1]])


def test_matrices_are_stored_column_by_column() -> None:
    binary = struct.pack("<16f", *range(16))
    views = [{"buffer": 0, "byteLength": 64}]
    found = arrays(binary, views, [{"bufferView": 0, "componentType": 5126, "type": "MAT4", "count": 1}])
    np.testing.assert_array_equal(found.read(0)[0], np.arange(16.0).reshape(4, 4).T)


def test_a_data_address_is_decoded() -> None:
    uri = "data:application/octet-stream;base64," + base64.b64encode(struct.pack("<f", 2.5)).decode()
    document = {
        "buffers": [{"byteLength": 4, "uri": uri}],
        "bufferViews": [{"buffer": 0, "byteLength": 4}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "SCALAR", "count": 1}],
    }
    np.testing.assert_array_equal(GltfArrays(document, b"").read(0), [2.5])


@pytest.mark.parametrize(
    "uri", ["a.bin", "../a.bin", "http://example.org/a.bin", "data:text/plain,abc", "data:x;base64,@@"]
)
def test_no_other_address_is_followed(uri: str) -> None:
    with pytest.raises(ValueError, match=r"another file|cannot be decoded"):
        GltfArrays({"buffers": [{"byteLength": 4, "uri": uri}]}, b"")
