"""The envelope of a binary glTF file: one JSON chunk, then at most one binary chunk.

Written and read here once, because the model (gltf) and an uploaded scan (scan) come in the same envelope.
Whoever reads turns the `ValueError` into its own kind of BadInput.
"""

import json
import struct
from typing import Any

MAGIC = b"glTF"
JSON_CHUNK = 0x4E4F534A
BINARY_CHUNK = 0x004E4942


def pack_glb(text: bytes, binary: bytes) -> bytes:
    """A .glb of this JSON text and binary chunk, each padded to four bytes as the format asks."""
    parts = []
    for kind, content, padding in ((JSON_CHUNK, text, b" "), (BINARY_CHUNK, binary, b"\0")):
        if content or kind == JSON_CHUNK:
            more = padding * (-len(content) % 4)
            parts += [struct.pack("<II", len(content) + len(more), kind), content, more]
    return b"".join([MAGIC, struct.pack("<II", 2, 12 + sum(map(len, parts))), *parts])  # megabytes, copied once


def split_glb(data: bytes) -> tuple[dict[str, Any], bytes]:
    """(document, binary chunk or b"") of a .glb; ValueError with the end of a sentence when it is none."""
    if len(data) < 20 or data[:4] != MAGIC:
        raise ValueError("it does not begin like a binary glTF file")
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise ValueError(f"it is glTF version {version}, only version 2 is read")
    if length > len(data):
        raise ValueError(f"it is cut off: {len(data)} of {length} bytes are there")
    document: dict[str, Any] | None = None
    binary, offset = b"", 12
    while offset + 8 <= length:
        size, kind = struct.unpack_from("<II", data, offset)
        chunk = data[offset + 8 : offset + 8 + size]
        if len(chunk) != size:
            raise ValueError("a chunk reaches beyond the end of the file")
        if document is None:
            if kind != JSON_CHUNK:
                raise ValueError("its first chunk is not JSON")
            document = parse_document(chunk)
        elif kind == BINARY_CHUNK and not binary:
            binary = chunk
        offset += 8 + size
    if document is None:
        raise ValueError("it has no JSON chunk")
    return document, binary


def parse_document(text: bytes) -> dict[str, Any]:
    """The JSON object of a glTF; ValueError when it is not one."""
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ValueError("its JSON cannot be read") from error
    if not isinstance(document, dict):
        raise ValueError("its JSON is not an object")
    return document
