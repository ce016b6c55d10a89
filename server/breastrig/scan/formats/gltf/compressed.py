"""Decodes Draco and meshopt compression in a GLB, with their own decoders (extra `breastrig[formats]`).

Decoded arrays are as untrusted as ordinary ones: their indices are checked with those of all other files.
"""

from typing import Any

from breastrig.core.arrays import Integers
from breastrig.core.errors import BadScan, TooLarge
from breastrig.core.gltf_arrays import whole
from breastrig.scan.limits import FILE_BYTES, MEBIBYTE, TOO_MANY_TRIANGLES, TRIANGLES, VERTICES

DRACO = "KHR_draco_mesh_compression"
MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")
MOST_STRIDE = 256
HOW_TO_OPEN = 'This GLB file is compressed ({}); install "breastrig[formats]", or export it without compression.'


def draco_mesh(data: bytes) -> tuple[dict[int, Any], Integers]:
    """The attributes, as arrays by their numbers in the file, and the (F, 3) triangles.

    Raises BadScan or TooLarge with a sentence.
    """
    try:
        import DracoPy
    except ImportError:
        raise BadScan(HOW_TO_OPEN.format("Draco")) from None
    try:
        mesh = DracoPy.decode(data)
        faces = mesh.faces.astype("i8")
        attributes = {int(each["unique_id"]): each["data"] for each in mesh.attributes}
    except Exception as error:  # a decoder of untrusted bytes can raise anything
        raise BadScan("This GLB file is damaged: its Draco data cannot be unpacked; export it again.") from error
    if len(faces) > TRIANGLES or max(map(len, attributes.values()), default=0) > VERTICES:
        raise TooLarge(TOO_MANY_TRIANGLES)
    return attributes, faces


def unpacked_views(document: dict[str, Any], binary: bytes) -> bytes:
    """The buffer with all views unpacked behind it, where the document then finds them.

    Raises BadScan or TooLarge with a sentence, or ValueError for what makes no sense.
    """
    packed = [(view, found) for view in document.get("bufferViews", []) if (found := _compression(view)) is not None]
    if not packed:
        return binary
    try:
        import meshopt
    except ImportError:
        raise BadScan(HOW_TO_OPEN.format("meshopt")) from None
    parts, size = [binary], len(binary)
    for view, found in packed:
        count, stride = (
            whole(found.get("count"), "a count"),
            whole(found.get("byteStride"), "a stride", MOST_STRIDE + 1),
        )
        start, length = whole(found.get("byteOffset", 0), "an offset"), whole(found.get("byteLength"), "a length")
        if size + count * stride > FILE_BYTES:
            raise TooLarge(f"This GLB file unpacks to more than the {FILE_BYTES // MEBIBYTE} MB allowed; simplify it.")
        try:
            mode, filtered = found.get("mode"), found.get("filter", "NONE")
            content = meshopt.decode_gltf_buffer(
                binary[start : start + length], count, stride, mode, filtered
            ).tobytes()
        except Exception as error:  # a decoder of untrusted bytes can raise anything
            raise ValueError("its compressed data (meshopt) cannot be unpacked") from error
        view |= {"buffer": 0, "byteOffset": size, "byteLength": len(content)}
        if mode == "ATTRIBUTES":
            view["byteStride"] = stride
        padding = b"\0" * (-len(content) % 4)
        parts += [content, padding]
        size += len(content) + len(padding)
    return b"".join(parts)


def _compression(view: dict[str, Any]) -> dict[str, Any] | None:
    extensions = view.get("extensions", {})
    return next((extensions[name] for name in MESHOPT if name in extensions), None)
