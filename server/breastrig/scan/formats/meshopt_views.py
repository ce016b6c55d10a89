"""Buffer views that meshopt compressed (gltfpack does), by its own decoder, which `breastrig[formats]` brings."""

from typing import Any

from breastrig.core.errors import BadScan, TooLarge
from breastrig.core.gltf_arrays import whole
from breastrig.scan.limits import FILE_BYTES, MEBIBYTE

EXTENSIONS = ("EXT_meshopt_compression", "KHR_meshopt_compression")
HOW_TO_OPEN = 'This GLB file is compressed (meshopt); install "breastrig[formats]", or export it without compression.'
MOST_STRIDE = 256


def unpacked(document: dict[str, Any], binary: bytes) -> bytes:
    """The buffer with all views unpacked behind it, where the document then finds them.

    Raises BadScan or TooLarge with a sentence, or ValueError for what makes no sense.
    """
    packed = [(view, found) for view in document.get("bufferViews", []) if (found := _compression(view)) is not None]
    if not packed:
        return binary
    try:
        import meshopt
    except ImportError:
        raise BadScan(HOW_TO_OPEN) from None
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
    return next((extensions[name] for name in EXTENSIONS if name in extensions), None)
