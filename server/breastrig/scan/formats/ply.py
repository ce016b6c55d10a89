"""PLY: any elements, as text or binary, with lists of any length, colours and texture of vertices, faces or corners.

A header may hold anything in its comments, in any character set, and may announce more than the file has: sizes are
checked before anything is allocated.  A file that ends early is refused, for half a body looks like a whole one.
"""

import re
from array import array
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.formats.polygons import fans, few_corners, ranges, split, strip, whole_numbers
from breastrig.scan.limits import PLY_HEADER_BYTES, TOO_MANY_POINTS, TOO_MANY_TRIANGLES, TRIANGLES, VERTICES
from breastrig.scan.pictures.companions import UNPLACED, Companions
from breastrig.scan.pictures.tiles import painted_by_tiles
from breastrig.scan.piece import SEVERAL, Piece, Pieces, PointCloud, colour_bytes, part
from breastrig.scan.point_clouds.numbers_in_text import numbers

BYTE_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
TYPES = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"},
    **{"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"},
    **{"int64": "i8", "uint64": "u8", "float16": "f2", "float": "f4", "float32": "f4", "double": "f8", "float64": "f8"},
}
COLOURS = re.compile(r"(|diffuse_|\w*?)red")  # of the first of three; the shortest name has the skin's own
PLACES_IN_PICTURE = re.compile(r"((?:\w*(?:tex|uv)\w*?|t)??)([us])(_?0?)")  # of the first of two: u and v, s and t
CORNERS = ("vertex_indices", "vertex_index")
NORMAL = ("nx", "ny", "nz")
SPLAT_COLUMN = "f_dc_0"
END = re.compile(rb"end_header[ \t]*(\r\n|\n|\r)")
PICTURE = re.compile(r"(?:comment|obj_info)\s+texture(?:_?file)?\s*[:=]?\s+(\S.*)", re.IGNORECASE)
SPLATS = (
    "This PLY holds a cloud of Gaussian splats, which is a picture and no surface; "
    "export the mesh or the point cloud of this scan."
)
NO_POINTS = "This scan has no triangles; export it as a triangle mesh."


@dataclass(frozen=True)
class Property:
    name: str  # lower case
    kind: str  # numpy's, without byte order
    length: str | None = None  # of a list: the kind of its length


@dataclass(frozen=True)
class Element:
    name: str  # lower case
    count: int
    properties: tuple[Property, ...]


@dataclass(frozen=True, eq=False)
class Ragged:
    """Lists of N rows."""

    counts: Integers  # (N,)
    values: NDArray[Any]  # all of them, one row after the other


Columns = dict[str, NDArray[Any] | Ragged]


def read_ply(data: bytes, files: Companions, texture: bool) -> Pieces:
    """The file's meshes or points. Raises BadScan, TooLarge, or ValueError where it is damaged or cut off."""
    form, elements, named, at = _header(data)
    if max(element.count for element in elements) > VERTICES or any(
        element.name == "face" and element.count > TRIANGLES for element in elements
    ):
        draws = any(element.name in ("face", "tristrips") and element.count for element in elements)
        raise TooLarge(TOO_MANY_TRIANGLES if draws else TOO_MANY_POINTS)
    if sum(element.count for element in elements) > len(data) - at:  # each takes a byte at least
        raise ValueError("more rows than bytes")
    read = _text(data[at:], elements) if form == "ascii" else _binary(data, at, elements, BYTE_ORDERS[form])
    vertex, face = read.get("vertex", {}), read.get("face", {})
    if not set("xyz") <= set(vertex):
        raise BadScan(NO_POINTS)
    vertices = _table(vertex, tuple("xyz"))
    faces, polygons = _faces(face, read.get("tristrips", {}))
    drawn = _corners(face)
    few = 0 if drawn is None else int((drawn.counts < 3).sum())
    if few:
        files.note(few_corners(few))
    if not len(faces):
        return replace(_cloud(vertex, vertices), notes=files.notes())
    if not 0 <= faces.min() <= faces.max() < len(vertices):
        raise BadScan("The triangles of this scan name vertices that do not exist; export it again.")
    return _Painted(vertex, face, vertices, faces, polygons, named).pieces(files, texture)


def _header(data: bytes) -> tuple[str, list[Element], list[str], int]:
    """(format, elements, pictures' names, bytes before the rows); ValueError where it makes no sense."""
    end = END.search(data, 0, PLY_HEADER_BYTES)
    if end is None:
        raise ValueError("no end of the header")
    form, pictures = "", []
    found: list[tuple[str, int, list[Property]]] = []
    for line in _decoded(data[: end.start()]).splitlines()[1:]:
        words = line.split()
        if words[:1] == ["format"]:
            form = words[1]
        elif words[:1] in (["comment"], ["obj_info"]):
            picture = PICTURE.match(line.strip())
            if picture is not None:
                pictures.append(picture[1].strip())
        elif words[:1] == ["element"]:
            _, name, count = words
            if not re.fullmatch(r"\d{1,18}", count):
                raise ValueError("a count that is none")
            found.append((name.lower(), int(count), []))
        elif words[:1] == ["property"]:
            found[-1][2].append(_property(words[1:]))
    if form not in BYTE_ORDERS or not found or len({name for name, _, _ in found}) != len(found):
        raise ValueError("no format, or no elements of different names")
    elements = [Element(name, count, tuple(properties)) for name, count, properties in found]
    return form, elements, list(dict.fromkeys(pictures)), end.end()


def _property(words: list[str]) -> Property:
    if words[0] == "list":
        _, length, kind, name = words
        if TYPES[length][0] == "f":
            raise ValueError("a list whose length is no whole number")
        return Property(name.lower(), TYPES[kind], TYPES[length])
    kind, name = words
    return Property(name.lower(), TYPES[kind])


def _decoded(text: bytes) -> str:
    try:
        return text.decode()
    except UnicodeDecodeError:
        return text.decode("latin-1")


def _text(data: bytes, elements: list[Element]) -> dict[str, Columns]:
    lines = [line for line in data.splitlines() if line.strip()]
    read, at = {}, 0
    for element in elements:
        rows = lines[at : at + element.count]
        if len(rows) < element.count:
            raise ValueError("too few rows")
        values, widths = numbers(rows)
        ends = np.cumsum(widths)
        read[element.name] = _columns(element, values, ends - widths, ends)
        at += element.count
    return read


def _columns(element: Element, values: Array, at: Integers, ends: Integers) -> Columns:
    """Each property's numbers, in rows that start at `at` and end before `ends`."""
    found: Columns = {}
    for each in element.properties:
        if len(at) and (at >= ends).any():
            raise ValueError("a row with too few numbers")
        column = values[at]
        at = at + 1
        if each.length is not None:
            counts = whole_numbers(column)
            if (counts < 0).any() or (at + counts > ends).any():
                raise ValueError("a list that is longer than its row")
            column = values[ranges(at, counts)]
            at = at + counts
        with np.errstate(all="ignore"):  # numbers that their kind cannot hold are looked at like all others
            stored = column.astype(each.kind)
        if each.kind[0] == "f" or np.array_equal(stored, column):
            column = stored  # else there are shares in what should be whole numbers
        found.setdefault(each.name, column if each.length is None else Ragged(counts, column))
    return found


def _binary(data: bytes, at: int, elements: list[Element], order: str) -> dict[str, Columns]:
    read = {}
    for element in elements:
        read[element.name], at = _rows(data, at, element, order)
    return read


def _rows(data: bytes, at: int, element: Element, order: str) -> tuple[Columns, int]:
    """The element's columns, and where the next begins."""
    if not element.count or not element.properties:
        return {}, at
    first = _layout(element, order, _lengths(data, at, element, order))
    end = at + element.count * first.itemsize
    if end <= len(data):
        table = np.frombuffer(data, first, element.count, at)
        lists = [index for index, each in enumerate(element.properties) if each.length is not None]
        if all((table[f"{index} length"] == table[f"{index} length"][0]).all() for index in lists):
            return {
                each.name: table[str(index)]
                if each.length is None
                else Ragged(table[f"{index} length"].astype(np.int64), table[str(index)].reshape(-1))
                for index, each in reversed(list(enumerate(element.properties)))
            }, end
    return _walked(data, at, element, order)


def _lengths(data: bytes, at: int, element: Element, order: str) -> list[int]:
    """The lengths of the lists of one row."""
    found = []
    for each in element.properties:
        if each.length is not None:
            kind = np.dtype(order + each.length)
            if at + kind.itemsize > len(data):
                raise ValueError("cut off")
            found.append(int(np.frombuffer(data, kind, 1, at)[0]))
            if not 0 <= found[-1] <= len(data):
                raise ValueError("a list that is longer than the file")
            at += kind.itemsize + found[-1] * np.dtype(each.kind).itemsize
        else:
            at += np.dtype(each.kind).itemsize
    return found


def _layout(element: Element, order: str, lengths: list[int]) -> np.dtype[Any]:
    fields: list[Any] = []
    waiting = iter(lengths)
    for index, each in enumerate(element.properties):
        if each.length is None:
            fields.append((str(index), order + each.kind))
        else:
            fields += [(f"{index} length", order + each.length), (str(index), order + each.kind, (next(waiting),))]
    return np.dtype(fields)


def _walked(data: bytes, at: int, element: Element, order: str) -> tuple[Columns, int]:
    """The rows of an element whose lists differ in length, read one after the other."""
    byte_order: Literal["big", "little"] = "big" if order == ">" else "little"
    lists: list[tuple[int, np.dtype[Any], int]] = []  # bytes before it, the kind of its length, bytes of an item
    places: list[tuple[int, int]] = []  # of each property: the lists before it, and bytes behind the last of them
    before = 0
    for each in element.properties:
        size = np.dtype(each.kind).itemsize
        places.append((len(lists), before))
        before += size
        if each.length is not None:
            lists.append((before - size, np.dtype(each.length), size))
            before = 0
    walked, lengths = [array("q") for _ in range(len(lists) + 1)], [array("q") for _ in lists]
    for _ in range(element.count):
        walked[0].append(at)
        for index, (skipped, kind, size) in enumerate(lists):
            at += skipped + kind.itemsize
            count = int.from_bytes(data[at - kind.itemsize : at], byte_order)
            at += count * size
            lengths[index].append(min(count, len(data)))
            walked[index + 1].append(min(at, len(data)))
        at += before
        if at > len(data):
            raise ValueError("cut off")
    starts, counts = (np.array(found, np.int64).reshape(-1, element.count) for found in (walked, lengths))
    if int(counts.sum()) > 2 * VERTICES:
        raise TooLarge(TOO_MANY_TRIANGLES)
    content, found = np.frombuffer(data, np.uint8), dict[str, Any]()
    for each, (behind, offset) in reversed(list(zip(element.properties, places, strict=True))):
        size = np.dtype(each.kind).itemsize
        if each.length is None:
            cells = starts[behind] + offset
            found[each.name] = content[cells[:, None] + np.arange(size)].view(order + each.kind).reshape(-1)
            continue
        first = starts[behind + 1] - size * counts[behind]
        cells = np.repeat(first, counts[behind]) + size * ranges(0 * counts[behind], counts[behind])
        values = content[cells[:, None] + np.arange(size)].view(order + each.kind).reshape(-1)
        found[each.name] = Ragged(counts[behind], values)
    return found, at


def _table(columns: Columns, names: tuple[str, ...]) -> Array:
    """(N, k)"""
    with np.errstate(all="ignore"):
        return np.stack([np.asarray(columns[name]).astype(np.float64) for name in names], axis=1)


def _corners(face: Columns) -> Ragged | None:
    """The list of a polygon's vertices: under its usual names, else the first of whole numbers."""
    usual = (found for name in CORNERS if isinstance(found := face.get(name), Ragged))
    whole = (each for each in face.values() if isinstance(each, Ragged) and each.values.dtype.kind in "iu")
    return next(usual, None) or next(whole, None)


def _faces(face: Columns, strips: Columns) -> tuple[Integers, Integers]:
    """(F, 3) triangles of polygons and strips, and (F,) the polygon of each; -1 in a strip."""
    corners = _corners(face)
    faces, polygons = np.zeros((0, 3), np.int64), np.zeros(0, np.int64)
    if corners is not None:
        if len(corners.counts) and int(np.maximum(corners.counts - 2, 0).sum()) > TRIANGLES:
            raise TooLarge(TOO_MANY_TRIANGLES)
        order, polygons = fans(corners.counts)
        faces = whole_numbers(corners.values)[order]
    for each in strips.values():
        if isinstance(each, Ragged):
            if len(each.values) > VERTICES:
                raise TooLarge(TOO_MANY_TRIANGLES)
            values = whole_numbers(each.values)
            ends = np.union1d(np.cumsum(each.counts), np.flatnonzero(values == -1))
            more = [strip(part[part != -1]) for part in np.split(values, ends)]
            found = np.concatenate([*more, np.zeros((0, 3), np.int64)])
            has_area = (found != np.roll(found, 1, axis=1)).all(axis=1)  # strips are joined by triangles without one
            faces = np.concatenate([faces, found[has_area]])
            polygons = np.concatenate([polygons, np.full(int(has_area.sum()), -1)])
    return faces, polygons


def _colours(columns: Columns) -> NDArray[np.uint8] | None:
    """(N, 3) of whole numbers up to 255, 65,535 or their type's maximum, or of floats up to 1 or 255."""
    firsts = sorted((name for name in columns if COLOURS.fullmatch(name)), key=lambda name: (len(name), name))
    triples = [(name, f"{name[:-3]}green", f"{name[:-3]}blue") for name in firsts]
    names = next((names for names in (*triples, tuple("rgb")) if _are_numbers(columns, names)), None)
    if names is None:
        return None
    kind, values = np.asarray(columns[names[0]]).dtype, _table(columns, names)
    if kind.kind not in "iu":
        return colour_bytes(values)
    most = values.max(initial=0.0)
    return colour_bytes(values, next((full for full in (255.0, 65535.0) if most <= full), float(np.iinfo(kind).max)))


def _are_numbers(columns: Columns, names: tuple[str, ...]) -> bool:
    return all(isinstance(columns.get(name), np.ndarray) for name in names)


def _places(columns: Columns) -> Array | None:
    """(N, 2) in the picture, from its lower left."""
    for name in columns:
        found = PLACES_IN_PICTURE.fullmatch(name)
        if found is not None:
            names = name, f"{found[1]}{'v' if found[2] == 'u' else 't'}{found[3]}"
            if _are_numbers(columns, names):
                return _table(columns, names)
    return None


def _cloud(vertex: Columns, points: Array) -> Pieces:
    if SPLAT_COLUMN in vertex:
        raise BadScan(SPLATS)
    if not len(points):
        raise BadScan(NO_POINTS)
    normals = _table(vertex, NORMAL) if set(NORMAL) <= set(vertex) else None
    return Pieces((), has_points=True, cloud=PointCloud(points, normals, _colours(vertex)))


class _Painted:
    """Triangles with their colours or pictures."""

    def __init__(
        self, vertex: Columns, face: Columns, vertices: Array, faces: Integers, polygons: Integers, named: list[str]
    ) -> None:
        self._vertex, self._face = vertex, face
        self._vertices, self._faces, self._polygons = vertices, faces, polygons
        self._named = named
        self._of_polygons = not (polygons < 0).any()  # and none of strips, which have no properties

    def pieces(self, files: Companions, texture: bool) -> Pieces:
        painted = self._with_pictures(files) if texture else ()
        return Pieces(painted or (self._with_colours(),), notes=files.notes())

    def _with_colours(self) -> Piece:
        colours = _colours(self._vertex)
        of_faces = _colours(self._face) if colours is None and self._of_polygons else None
        if of_faces is None:
            return Piece(self._vertices, self._faces, colours)
        corners = np.repeat(of_faces[self._polygons][:, None].astype(np.float64), 3, axis=1)
        which, faces, values = split(self._faces, corners)
        return Piece(self._vertices[which], faces, values.astype(np.uint8))

    def _with_pictures(self, files: Companions) -> tuple[Piece, ...]:
        """A piece for each picture; none where there is no picture or no place in it."""
        found = self._with_places()
        if found is not None and len(self._named) == 1:
            painted = painted_by_tiles(found, self._named[0], files)
            return painted if any(each.picture for each in painted) else ()
        pictures = [files.picture(name) for name in self._named]
        if found is None:
            if any(pictures):
                files.note(UNPLACED)
            return ()
        if not pictures and found.colours is None:
            pictures = [files.only_picture()]
        if not any(pictures):
            return ()
        if len(pictures) == 1:
            return (replace(found, picture=pictures[0]),)
        number = self._face.get("texnumber")
        if not isinstance(number, np.ndarray) or not self._of_polygons:
            files.note(SEVERAL)
            return ()
        numbered = whole_numbers(number)[self._polygons]
        return tuple(
            replace(part(found, numbered == index), picture=pictures[index] if 0 <= index < len(pictures) else None)
            for index in np.unique(numbered)
        )

    def _with_places(self) -> Piece | None:
        """The mesh with texture coordinates per vertex or per polygon corner; None where the file has none."""
        colours = _colours(self._vertex)
        places = _places(self._vertex)
        if places is not None:
            return Piece(self._vertices, self._faces, colours, places)
        corners, polygon = self._face.get("texcoord"), _corners(self._face)
        if not isinstance(corners, Ragged) or polygon is None or not self._of_polygons:
            return None
        if not np.array_equal(corners.counts, 2 * polygon.counts):
            return None
        order, _ = fans(polygon.counts)
        which, faces, uv = split(self._faces, corners.values.reshape(-1, 2).astype(np.float64)[order])
        return Piece(self._vertices[which], faces, None if colours is None else colours[which], uv)
