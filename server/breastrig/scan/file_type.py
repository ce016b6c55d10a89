"""What kind of file some bytes are, from the bytes; the name only helps to say what is wrong."""

import re

from breastrig.core.errors import BadScan

FILE_TYPES = ("ply", "obj", "stl", "glb", "zip")
BINARY_STL_HEADER = 84  # bytes: a title and the number of triangles
BINARY_STL_TRIANGLE = 50  # bytes
LOOKED_AT = 4096  # bytes in which a text file shows what it is
EXPORT = "export the scan as PLY, OBJ, STL or GLB"


def file_type_of(data: bytes, named: str | None = None) -> str:
    """One of FILE_TYPES; BadScan with a sentence when the bytes are none of them.

    `named` is the file name's ending.  It decides only for a binary STL of the wrong length (which has no mark
    of its own) so that the sentence can say that it is cut off.
    """
    start = data[:LOOKED_AT]
    named = (named or "").lower().lstrip(".")
    if not data:
        raise BadScan(f"The file is empty; {EXPORT}.")
    if start.startswith(b"glTF"):
        return "glb"
    if re.match(rb"ply\s*[\r\n]", start):
        return "ply"
    if start.startswith((b"PK\x03\x04", b"PK\x05\x06")):
        return "zip"
    if is_binary_stl(data) or (re.match(rb"\s*solid\b", start, re.IGNORECASE) and b"facet" in start):
        return "stl"
    if b"\0" not in start and re.search(rb"(?:^|[\r\n])[ \t]*v[ \t]+[-+.\d]", data):
        return "obj"
    if re.match(rb"\s*\{", start) and b'"asset"' in data:
        raise BadScan("This is a .gltf, which keeps its data in other files; export the scan as one .glb.")
    if named == "stl" and b"\0" in start:
        raise BadScan("This STL file is cut off or damaged: its length does not fit its triangles; export it again.")
    if named in FILE_TYPES:
        raise BadScan(f"This file is named .{named} but holds no {named.upper()} data; {EXPORT}.")
    raise BadScan(f"This is not a PLY, OBJ, STL, GLB or zip file; {EXPORT}.")


def is_binary_stl(data: bytes) -> bool:
    """Whether the length is just what the number of triangles asks for."""
    count = int.from_bytes(data[BINARY_STL_HEADER - 4 : BINARY_STL_HEADER], "little")
    return len(data) == BINARY_STL_HEADER + BINARY_STL_TRIANGLE * count and len(data) >= BINARY_STL_HEADER
