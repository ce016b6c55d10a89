"""Accessors of a glTF document as numpy arrays, whoever wrote it: the model's and those of scans.

Reads what exporters really produce: strides, sparse accessors (Blender's default for shapes), normalised
integers, a binary chunk or data URIs.  Nothing is ever opened or fetched: a buffer with any other URI is
refused.  Every failure is a ValueError with the end of a sentence.
"""

import base64
import binascii
from typing import Any

import numpy as np
from numpy.typing import NDArray

DTYPES = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
SHAPES: dict[str, tuple[int, ...]] = {
    "SCALAR": (),
    "VEC2": (2,),
    "VEC3": (3,),
    "VEC4": (4,),
    "MAT2": (2, 2),
    "MAT3": (3, 3),
    "MAT4": (4, 4),
}
NUMBERS_LIMIT = 50_000_000  # in one accessor: a file cannot ask for more memory than it could fill


class GltfArrays:
    """The document's accessors, read on demand."""

    def __init__(self, document: dict[str, Any], binary: bytes) -> None:
        self._document = document
        self._buffers = [_buffer(entry, binary, index) for index, entry in enumerate(document.get("buffers", []))]

    def read(self, index: Any) -> NDArray[Any]:
        """(count, ...) float64 for floats and normalised integers, int64 for other integers."""
        values = self.stored(index)
        if values.dtype == np.float32:
            with np.errstate(invalid="ignore"):  # a signalling NaN is for the caller to find, not a warning
                return values.astype(np.float64)
        if entry(self._document, "accessors", index).get("normalized"):
            return np.maximum(values.astype(np.float64) / np.iinfo(values.dtype).max, -1.0)
        return values.astype(np.int64)

    def stored(self, index: Any) -> NDArray[Any]:
        """(count, ...) in the number format of the file."""
        accessor = entry(self._document, "accessors", index)
        dtype, shape, count = _layout(accessor, index)
        if "bufferView" in accessor:
            values = self._view(accessor["bufferView"], accessor.get("byteOffset", 0), dtype, shape, count)
        else:
            values = np.zeros((count, *shape), dtype)
        if "sparse" in accessor:
            values = self._with_sparse(values, accessor["sparse"], dtype, shape)
        return values.transpose(0, 2, 1) if len(shape) == 2 else values  # matrices lie there column by column

    def _with_sparse(
        self, values: NDArray[Any], sparse: dict[str, Any], dtype: Any, shape: tuple[int, ...]
    ) -> NDArray[Any]:
        places, changes = sparse["indices"], sparse["values"]
        count = whole(sparse.get("count"), "a sparse count")
        index_dtype = np.dtype(DTYPES[places["componentType"]])
        rows = self._view(places["bufferView"], places.get("byteOffset", 0), index_dtype, (), count)
        new = self._view(changes["bufferView"], changes.get("byteOffset", 0), dtype, shape, count)
        if count and int(rows.max()) >= len(values):
            raise ValueError("a sparse accessor points beyond its end")
        values = values.copy()
        values[rows] = new
        return values

    def _view(self, index: Any, offset: Any, dtype: Any, shape: tuple[int, ...], count: int) -> NDArray[Any]:
        """(count, *shape) of `dtype` from a buffer view, which may be interleaved with others."""
        view = entry(self._document, "bufferViews", index)
        buffer = self._buffers[whole(view.get("buffer"), "a buffer's number", len(self._buffers))]
        start = whole(view.get("byteOffset", 0), "an offset")
        data = buffer[start : start + whole(view.get("byteLength"), "a length")]
        data = data[whole(offset, "an offset") :]
        size = dtype.itemsize * int(np.prod(shape))
        stride = whole(view.get("byteStride", size), "a stride")
        if count == 0:
            return np.zeros((0, *shape), dtype)
        if stride < size or len(data) < stride * (count - 1) + size:
            raise ValueError("an accessor reaches beyond the end of its buffer")
        rows = np.lib.stride_tricks.as_strided(np.frombuffer(data, np.uint8), (count, size), (stride, 1))
        values: NDArray[Any] = np.ascontiguousarray(rows).view(dtype.newbyteorder("<")).reshape(count, *shape)
        return values.astype(dtype)


def entry(document: dict[str, Any], kind: str, index: Any) -> dict[str, Any]:
    """document[kind][index], checked."""
    items = document.get(kind, [])
    found = items[whole(index, f"an index of {kind}", len(items))]
    if not isinstance(found, dict):
        raise ValueError(f"an entry of {kind} is not an object")
    return found


def whole(value: Any, what: str, below: int | None = None) -> int:
    """A whole number, zero or more, and less than `below`."""
    if not isinstance(value, int) or isinstance(value, bool) or value < 0 or (below is not None and value >= below):
        raise ValueError(f"{what} is missing or out of range")
    return value


def _layout(accessor: dict[str, Any], index: Any) -> tuple[Any, tuple[int, ...], int]:
    kind, component = accessor.get("type"), accessor.get("componentType")
    if kind not in SHAPES or component not in DTYPES:
        raise ValueError(f"accessor {index} has an unknown type")
    count = whole(accessor.get("count"), "a count")
    if count * int(np.prod(SHAPES[kind])) > NUMBERS_LIMIT:
        raise ValueError(f"accessor {index} is too large")
    return np.dtype(DTYPES[component]), SHAPES[kind], count


def _buffer(buffer: dict[str, Any], binary: bytes, index: int) -> bytes:
    uri = buffer.get("uri")
    if uri is None and index == 0:
        return binary
    if not isinstance(uri, str) or not uri.startswith("data:") or ";base64," not in uri[:100]:
        raise ValueError("its data lies in another file, export it as one .glb")
    try:
        return base64.b64decode(uri.split(",", 1)[1], validate=True)
    except (ValueError, binascii.Error) as error:
        raise ValueError("its data URI cannot be decoded") from error
