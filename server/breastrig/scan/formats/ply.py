"""A PLY file's own account of itself, checked and written anew before a library reads the file.

The header may hold anything beside the sizes: names and dates in comments, in whatever character set the scanner's
computer had, which alone makes libraries give up.  What is handed on is a header of elements, properties and the
picture's name, and, of a text file, exactly as many rows as it announces: a file that ends earlier is refused here,
because libraries take what is there.
"""

import re
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from breastrig.scan.limits import PLY_HEADER_BYTES

FORMATS = ("ascii", "binary_little_endian", "binary_big_endian")
BYTE_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">"}
TYPES = {  # numpy's names
    **{"char": "<i1", "uchar": "<u1", "short": "<i2", "ushort": "<u2", "int": "<i4", "uint": "<u4"},
    **{"int8": "<i1", "uint8": "<u1", "int16": "<i2", "uint16": "<u2", "int32": "<i4", "uint32": "<u4"},
    **{"int64": "<i8", "uint64": "<u8", "float16": "<f2", "float": "<f4", "float32": "<f4"},
    **{"double": "<f8", "float64": "<f8"},
}
COLOURS = ("red", "green", "blue")
ALSO_COLOURS = (("diffuse_red", "diffuse_green", "diffuse_blue"), ("r", "g", "b"))  # where the usual names are missing
READ = ("vertex", "face")  # elements; others are stepped over under a name that means nothing
END = re.compile(rb"end_header[ \t]*(\r\n|\n|\r)")
PICTURE = re.compile(r"comment\s+texturefile\s+(.+)", re.IGNORECASE)


@dataclass(frozen=True)
class Element:
    name: str
    count: int
    properties: tuple[tuple[str, ...], ...]  # words: (type, name) or (list, type of the length, type, name)


@dataclass(frozen=True)
class PlyHeader:
    form: str  # one of FORMATS
    elements: tuple[Element, ...]
    pictures: tuple[str, ...]  # names of files
    size: int  # bytes before the data

    @property
    def entries(self) -> int:
        """Of all elements together."""
        return sum(element.count for element in self.elements)

    def count(self, name: str) -> int:
        """How many of these are announced."""
        return sum(element.count for element in self.elements if element.name == name)

    def written(self) -> bytes:
        """The header with what is read, and nothing else."""
        lines = ["ply", f"format {self.form} 1.0"]
        if len(self.pictures) == 1:
            lines.append(f"comment TextureFile {self.pictures[0]}")
        for index, element in enumerate(self.elements):
            name = element.name if element.name in READ else f"other_{index}"
            lines.append(f"element {name} {element.count}")
            lines += [" ".join(("property", *words)) for words in element.properties]
        return "\n".join([*lines, "end_header", ""]).encode()


def ply_header(data: bytes) -> PlyHeader:
    """The header of a PLY file; ValueError when there is none, or one that cannot be read."""
    end = END.search(data, 0, PLY_HEADER_BYTES)
    if end is None:
        raise ValueError("no end of the header")
    form, pictures = "", []
    elements: list[tuple[str, int, list[tuple[str, ...]]]] = []
    for line in _decoded(data[: end.start()]).splitlines()[1:]:
        words = line.split()
        if not words or words[0] == "obj_info":
            continue
        if words[0] == "format":
            form = words[1]
        elif words[0] == "comment":
            found = PICTURE.match(line.strip())
            if found is not None:
                pictures.append(found[1].strip())
        elif words[0] == "element":
            _, name, count = words
            elements.append((name, _number(count), []))
        elif words[0] == "property":
            elements[-1][2].append(_property(words[1:]))
    if form not in FORMATS or not elements:
        raise ValueError("no format or nothing in it")
    if len({name for name, _, _ in elements}) != len(elements):
        raise ValueError("an element twice")
    return PlyHeader(
        form,
        tuple(Element(name, count, _usual_colours(properties)) for name, count, properties in elements),
        tuple(dict.fromkeys(pictures)),
        end.end(),
    )


def text_rows(data: bytes, header: PlyHeader) -> list[bytes] | None:
    """The rows of a text file that its header announces; None when there are fewer or the last is cut."""
    lines = [line for line in data[header.size :].splitlines() if line.strip()][: header.entries]
    if len(lines) < header.entries or (lines and not _is_whole(lines[-1], header)):
        return None
    return lines


def as_binary(rows: list[bytes], header: PlyHeader) -> tuple[str, bytes] | None:
    """(format, data) of a text file's rows; None where they differ in their form, as triangles beside quads do.

    The library takes some ten times longer for text, row by row.
    """
    parts, at = [], 0
    for element in header.elements:
        if element.count:
            try:
                part = _table(rows[at : at + element.count], element)
            except (DeprecationWarning, ValueError, IndexError):
                part = None
            if part is None:
                return None
            parts.append(part.tobytes())
        at += element.count
    return "binary_little_endian", b"".join(parts)


def _table(rows: list[bytes], element: Element) -> NDArray[Any] | None:
    """Rows of equally many numbers as an array of the types that the header announces."""
    first, width = rows[0].split(), 0
    columns: list[tuple[str, str, tuple[int, ...]]] = []  # numpy's words: name, type, shape in a row
    for words in element.properties:
        if words[0] == "list":
            length = int(first[width])
            if length > np.iinfo(TYPES[words[1]]).max:
                return None
            columns += [(f"length {width}", TYPES[words[1]], ()), (f"list {width}", TYPES[words[2]], (length,))]
            width += 1 + length
        else:
            columns.append((f"number {width}", TYPES[words[0]], ()))
            width += 1
    if any(len(row.split()) != width for row in rows):
        return None
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # words that are no numbers
        numbers = np.fromstring(b" ".join(rows).decode(), np.float64, sep=" ").reshape(len(rows), width)
    table, at = np.zeros(len(rows), columns), 0
    for name, _, shape in columns:
        values = numbers[:, at : at + shape[0]] if shape else numbers[:, at]
        if name.startswith("length") and (values != values[0]).any():
            return None
        with np.errstate(all="ignore"):  # numbers that the announced type cannot hold are checked as all others are
            table[name] = values
        at += values.shape[1] if shape else 1
    return table


def _is_whole(row: bytes, header: PlyHeader) -> bool:
    """Whether the last row has all its numbers."""
    element = next(element for element in reversed(header.elements) if element.count)
    numbers, needed = row.split(), 0
    try:
        for words in element.properties:
            needed += 1 + (int(numbers[needed]) if words[0] == "list" else 0)
    except (IndexError, ValueError):
        return False
    return len(numbers) >= needed


def _decoded(text: bytes) -> str:
    try:
        return text.decode()
    except UnicodeDecodeError:
        return text.decode("latin-1")


def _usual_colours(properties: list[tuple[str, ...]]) -> tuple[tuple[str, ...], ...]:
    """The properties, their colours under the names that readers know."""
    names = {words[-1] for words in properties}
    for others in ALSO_COLOURS:
        if names.isdisjoint(COLOURS) and names.issuperset(others):
            usual = dict(zip(others, COLOURS, strict=True))
            return tuple((*words[:-1], usual.get(words[-1], words[-1])) for words in properties)
    return tuple(properties)


def _number(word: str) -> int:
    if not re.fullmatch(r"\d{1,18}", word):
        raise ValueError("a count that is none")
    return int(word)


def _property(words: list[str]) -> tuple[str, ...]:
    types, kind = (words[1:3], 4) if words[0] == "list" else (words[:1], 2)
    if len(words) != kind or not set(types) <= set(TYPES) or (kind == 4 and TYPES[types[0]][1] == "f"):
        raise ValueError("a property of an unknown type")
    return tuple(words)
