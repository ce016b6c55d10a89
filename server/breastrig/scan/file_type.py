"""What kind of file some bytes are, from the bytes; the name only helps to say what is wrong."""

import re

from breastrig.core.errors import BadScan

FILE_TYPES = ("ply", "obj", "stl", "glb", "zip", "pcd", "xyz", "usd")
USD_LAYERS = (".usd", ".usda", ".usdc")
USD_STARTS = (b"PXR-USDC", b"#usda")
BINARY_STL_HEADER = 84  # bytes: a title and the number of triangles
BINARY_STL_TRIANGLE = 50  # bytes
LOOKED_AT = 4096  # bytes in which a text file shows what it is
PCD_START = re.compile(rb"^(?:\s*#[^\n]*\n|\s*\n)*\s*(?:VERSION|FIELDS|COLUMNS)\s", re.IGNORECASE)
ROWS = 20  # lines in which a file shows that it is nothing but numbers
COLUMNS = 12  # at most: place, normal, colour, and what a scanner adds
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
    if start.startswith(USD_STARTS) or _is_usdz(start):
        return "usd"
    if start.startswith((b"PK\x03\x04", b"PK\x05\x06")):
        return "zip"
    if is_binary_stl(data) or (re.match(rb"\s*solid\b", start, re.IGNORECASE) and b"facet" in start):
        return "stl"
    if PCD_START.match(start):
        return "pcd"
    if b"\0" not in start and re.search(rb"(?:^|[\r\n])[ \t]*v[ \t]+[-+.\d]", data):
        return "obj"
    if b"\0" not in start and is_point_text(start):
        return "xyz"
    if re.match(rb"\s*\{", start) and b'"asset"' in data:
        raise BadScan("This is a .gltf, which keeps its data in other files; export the scan as one .glb.")
    if named == "stl" and b"\0" in start:
        raise BadScan("This STL file is cut off or damaged: its length does not fit its triangles; export it again.")
    if named in FILE_TYPES:
        raise BadScan(f"This file is named .{named} but holds no {named.upper()} data; {EXPORT}.")
    raise BadScan(f"This is not a PLY, OBJ, STL, GLB, PCD or zip file; {EXPORT}.")


def is_binary_stl(data: bytes) -> bool:
    """Whether the length is just what the number of triangles asks for."""
    count = int.from_bytes(data[BINARY_STL_HEADER - 4 : BINARY_STL_HEADER], "little")
    return len(data) == BINARY_STL_HEADER + BINARY_STL_TRIANGLE * count and len(data) >= BINARY_STL_HEADER


def _is_usdz(start: bytes) -> bool:
    """Whether a zip's first file is a layer of USD, as the format of its packages wants it."""
    length = int.from_bytes(start[26:28], "little")
    return start.startswith(b"PK\x03\x04") and start[30 : 30 + length].decode("latin-1").lower().endswith(USD_LAYERS)


def is_point_text(start: bytes) -> bool:
    """Whether a file that starts so holds rows of three or more numbers, perhaps after one with their count."""
    lines = number_rows(start)[:ROWS]
    if len(lines) > 1 and len(lines[0].split()) == 1:
        lines = lines[1:]
    if len(lines) < 3:
        return False
    try:
        widths = {len([float(word) for word in line.split()]) for line in lines[:-1]}
    except ValueError:
        return False
    return len(widths) == 1 and 3 <= widths.pop() <= COLUMNS


def number_rows(data: bytes) -> list[bytes]:
    """With anything in them but a remark, commas and semicolons as spaces."""
    plain = data.replace(b",", b" ").replace(b";", b" ").replace(b"\t", b" ")
    return [line for line in plain.splitlines() if line.strip() and not line.lstrip().startswith((b"#", b"//"))]
