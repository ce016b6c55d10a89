"""OBJ: polygons with texture coordinates, colours behind the places, and the materials and pictures that they name.

OBJ announces nothing, so a file that was cut off within its triangles looks whole.  What gives it away: the last
triangle lacks a corner; the file says how many there should be (MeshLab's do); many points are left over that no
triangle uses, or any at all where the last line has no end; or such a last number seems to lack digits, because its
triangle reaches far across the body.  A cut exactly between two lines in which nearly all points are used is not seen.
"""

import re
from array import array
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.formats.mtl import Material, read_materials
from breastrig.scan.formats.polygons import fans, few_corners
from breastrig.scan.limits import MATERIALS, TOO_MANY_POINTS, TOO_MANY_TRIANGLES, TRIANGLES, VERTICES
from breastrig.scan.pictures.companions import ONLY_PAINTING, UNPLACED, Companions
from breastrig.scan.pictures.companions import REMARK as NAME_REMARK
from breastrig.scan.pictures.tiles import painted_by_tiles
from breastrig.scan.piece import PARTLY_COLOURED, UNCOLOURED, Piece, Pieces, PointCloud, colour_bytes, part
from breastrig.scan.point_clouds.numbers_in_text import REMARK, first_columns, numbers

LEFT_OVER = 0.1  # share of the points that no triangle uses; scanning programs leave none or single ones
COMPARED = 50  # triangles before the last
FAR_REACHING = 3.0  # times the longest edge of those
LONGEST_LINE = 20_000  # bytes of a polygon
CONTINUED = re.compile(rb"\\ *\n")
NUMBERED = (b"v", b"vt", b"f", b"fo")
ANNOUNCED = re.compile(rb"(?m)^# *Faces: *(\d{1,9}) *$")  # in MeshLab's header
LOOKED_AT = 4096  # bytes at the beginning, or the end
CUT_OFF = "This OBJ file ends in the middle of its triangles, as one that was cut off; export it again."
LOOSE = (
    "This OBJ file has many points without triangles, as one that was cut off; export it again, without loose points."
)


def read_obj(data: bytes, files: Companions, texture: bool) -> Pieces:
    """The file's meshes or points. Raises BadScan, TooLarge, or ValueError where it is damaged."""
    lines = _Lines(data)
    if lines.few_corners:
        files.note(few_corners(lines.few_corners))
    points, colours = _points(lines.points, files)
    if colours is None and lines.painted:
        colours = _zbrush_colours(lines.painted, len(points))
    if not lines.counts:
        if not len(points):
            raise BadScan("This OBJ file holds no triangles; export the scan as a triangle mesh.")
        return Pieces((), has_points=True, cloud=PointCloud(points, None, colours), notes=files.notes())
    corners = np.array([_corner(word) for word in lines.corners], np.int64).reshape(-1, 2)
    if corners[:, 0].min() < 1 or corners[:, 0].max() > len(points):
        raise BadScan("The triangles of this scan name vertices that do not exist; export it again.")
    order, polygons = fans(np.frombuffer(lines.counts, np.int64))
    faces = np.frombuffer(lines.polygons, np.int64)[order]
    _check_end(data, lines, points, corners[:, 0] - 1, faces)
    places = first_columns(lines.places, 2) if texture and lines.places else None
    if places is not None and ((corners[:, 1] < 1) | (corners[:, 1] > len(places))).all():
        places = None
    if places is None:
        whole = Piece(points, corners[faces, 0] - 1, colours)
    else:
        places = np.concatenate([places, [[np.nan, np.nan]]])  # of corners that have none
        in_picture = np.where((corners[:, 1] < 1) | (corners[:, 1] >= len(places)), len(places), corners[:, 1]) - 1
        keys, group = np.unique((corners[:, 0] - 1) * len(places) + in_picture, return_inverse=True)
        vertex, place = keys // len(places), keys % len(places)
        whole = Piece(points[vertex], group.ravel()[faces], None if colours is None else colours[vertex], places[place])
    return Pieces(tuple(_painted(whole, lines, polygons, files)) if texture else (whole,), notes=files.notes())


class _Lines:
    """The file's lines by what they say; corners that are counted backwards are counted from the beginning."""

    def __init__(self, data: bytes) -> None:
        self.points: list[bytes] = []
        self.places: list[bytes] = []
        self.painted: list[bytes] = []  # ZBrush's colours of the points, eight digits each: a mask and the colour
        self.libraries: list[str] = []
        self.materials: list[tuple[int, str]] = []  # from which polygon on, its name
        self.counts, self.polygons = array("q"), array("q")  # corners of each, and their numbers in `corners`
        self.corners: defaultdict[bytes, int] = defaultdict()
        self.corners.default_factory = self.corners.__len__
        self.few_corners = 0  # polygons that were left out
        self._triangles = normals = 0
        for line in _lines(data):
            word, _, rest = line.lstrip().partition(b" ")
            if b"#" in rest and word in NUMBERED:
                rest = REMARK.sub(b"", rest)
            if word == b"v":
                self.points.append(rest)
            elif word == b"vt":
                self.places.append(rest)
            elif word == b"vn":
                normals += 1
            elif word == b"#MRGB":
                self.painted.append(rest.strip())
            elif word == b"f" or word == b"fo":
                self._add(rest, normals)
            elif word.lower() == b"usemtl":
                self.materials.append((len(self.counts), _decoded(rest)))
            elif word.lower() == b"mtllib":
                self.libraries.append(_decoded(rest))
        if len({name for _, name in self.materials}) > MATERIALS:
            raise TooLarge(f"This OBJ file uses more than the {MATERIALS} materials allowed; join them.")
        if len(self.points) > VERTICES:
            raise TooLarge(TOO_MANY_TRIANGLES if self.counts else TOO_MANY_POINTS)

    def _add(self, rest: bytes, normals: int) -> None:
        if len(rest) > LONGEST_LINE:
            raise BadScan("This OBJ file has polygons with hundreds of corners; export it as triangles.")
        words = rest.split()
        if b"-" in rest:
            words = [_forwards(word, (len(self.points), len(self.places), normals)) for word in words]
        if len(words) < 3:
            self.few_corners += 1
            return
        self.counts.append(len(words))
        self._triangles += len(words) - 2
        if self._triangles > TRIANGLES:
            raise TooLarge(TOO_MANY_TRIANGLES)
        self.polygons.extend(map(self.corners.__getitem__, words))


def _uniform(data: bytes) -> bytes:
    """The data with one kind of line ends and spaces, without a byte order mark."""
    return data.removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n").replace(b"\r", b"\n").replace(b"\t", b" ")


def _lines(data: bytes) -> Iterable[bytes]:
    """The lines, those that go on in the next as one; a remark ends with its line, also where it names a folder."""
    data = _uniform(data)
    lines = data.split(b"\n")
    return _joined(lines) if CONTINUED.search(data) else lines


def _joined(lines: list[bytes]) -> Iterator[bytes]:
    waiting = b""
    for line in lines:
        whole = waiting + line
        waiting = b""
        bare = whole.rstrip()
        if bare.endswith(b"\\") and REMARK.search(whole) is None:
            waiting = bare[:-1] + b" "
        else:
            yield whole
    if waiting:
        yield waiting


def _decoded(text: bytes) -> str:
    try:
        return text.decode().strip()
    except UnicodeDecodeError:
        return text.decode("latin-1").strip()


def _forwards(word: bytes, counts: tuple[int, int, int]) -> bytes:
    """A corner such as -1, the last one so far, by its number from the beginning."""
    parts = word.split(b"/")
    return b"/".join(
        b"%d" % (count + 1 + int(part)) if part.startswith(b"-") else part
        for part, count in zip(parts, counts, strict=False)
    )


def _corner(word: bytes) -> tuple[int, int]:
    """The point's number, and that of its place in the picture or 0."""
    parts = word.split(b"/")
    return int(parts[0]), int(parts[1]) if len(parts) > 1 and parts[1] else 0


def _points(rows: list[bytes], files: Companions) -> tuple[Array, np.typing.NDArray[np.uint8] | None]:
    """(V, 3) places and (V, 3) colours: three more numbers, with an opacity sometimes."""
    found, widths = numbers(rows)
    if len(rows) and int(widths.min()) < 3:
        raise ValueError("a point with too few numbers")
    starts = np.cumsum(widths) - widths
    points = found[starts[:, None] + np.arange(3)]
    has_colour = (widths == 6) | (widths == 7)
    if not has_colour.any():
        return points, None
    colours = np.full((len(rows), 3), UNCOLOURED, np.uint8)
    colours[has_colour] = colour_bytes(found[starts[has_colour, None] + np.arange(3, 6)])
    if not has_colour.all():
        files.note(PARTLY_COLOURED)
    return points, colours


def _zbrush_colours(rows: list[bytes], points: int) -> np.typing.NDArray[np.uint8]:
    """(V, 3) of the points, grey where there are none."""
    digits = b"".join(rows).decode("ascii", "ignore")[: 8 * points]
    table = np.frombuffer(bytes.fromhex(digits[: len(digits) // 8 * 8]), np.uint8).reshape(-1, 4)
    colours = np.full((points, 3), UNCOLOURED, np.uint8)
    colours[: len(table)] = table[:, 1:]
    return colours


def _painted(whole: Piece, lines: _Lines, polygons: Integers, files: Companions) -> list[Piece]:
    """A piece for each material that differs in what it paints."""
    known: dict[str, Material] = {}
    for library in dict.fromkeys(lines.libraries):
        for content in files.material(library):
            known |= read_materials(content)
    if lines.materials and not lines.libraries:
        for content in files.material(""):
            known |= read_materials(content)
    starts = np.array([start for start, _ in lines.materials], np.int64)
    names = ["", *(name for _, name in lines.materials)]
    number = {name: index for index, name in enumerate(dict.fromkeys(names))}
    whose = np.array([number[name] for name in names])[np.searchsorted(starts, polygons, side="right")]
    used = {name: _named(name, known) for name in number}
    painting = {each for each in known.values() if each.picture}
    if len(painting) == 1 and not any(used.values()):  # the file names another material, or none
        files.note(ONLY_PAINTING)
        used = dict.fromkeys(used, *painting)
    pieces: dict[Material | None, list[int]] = {}
    for name, index in number.items():
        pieces.setdefault(used[name], []).append(index)
    unnamed = not any(material and material.picture for material in pieces)
    found: list[Piece] = []
    for material, own in pieces.items():
        chosen = np.isin(whose, own)
        if not chosen.any():
            continue
        piece = whole if chosen.all() else part(whole, chosen)
        found += _with_material(piece, material or Material(), files, unnamed)
    return found


def _named(written: str, known: dict[str, Material]) -> Material | None:
    """The material of this name, in any case, or of what stands before a remark."""
    names = (written, written.casefold(), NAME_REMARK.split(written)[0].rstrip())
    return next((known[name] for name in names if name in known), None)


def _with_material(piece: Piece, material: Material, files: Companions, unnamed: bool) -> Sequence[Piece]:
    if material.left_out:
        files.note(material.left_out)
    if piece.uv is None:
        if material.picture and files.picture(material.picture) is not None:
            files.note(UNPLACED)
        return [replace(piece, tint=material.tint)]
    placed = replace(piece, uv=piece.uv * material.scale + material.offset, tint=material.tint)
    if unnamed and piece.colours is None:
        return [replace(placed, picture=files.only_picture())]
    return painted_by_tiles(placed, material.picture, files) if material.picture else [placed]


def _check_end(data: bytes, lines: _Lines, points: Array, vertex: Integers, faces: Integers) -> None:
    """BadScan for a file that ends in the middle of its triangles."""
    announced = ANNOUNCED.search(data[:LOOKED_AT])
    if announced is not None:
        if len(lines.counts) < int(announced[1]):
            raise BadScan(CUT_OFF)
        return
    end = _uniform(data[-LOOKED_AT:])
    bare = (REMARK.sub(b"", line).split() for line in reversed(list(_lines(end))))
    last: list[bytes] = next((words for words in bare if words), [])
    if not last or last[0] != b"f":
        return
    if len(last) < 4 or len({tuple(map(bool, corner.split(b"/"))) for corner in last[1:]}) > 1:
        raise BadScan(CUT_OFF)
    used = len(np.unique(vertex[faces]))
    placed = int(
        np.isfinite(points).all(axis=1).sum()
    )  # depth cameras write a point that is no number where they see nothing
    if used < (1.0 - LEFT_OVER) * placed:
        raise BadScan(LOOSE)
    if not end.endswith(b"\n") and (used < placed or _lacks_digits(points, vertex[faces[-COMPARED - 1 :]])):
        raise BadScan(CUT_OFF)


def _lacks_digits(points: Array, faces: Integers) -> bool:
    """Whether the last number could have had another digit, and its triangle reaches across the body."""
    if (faces[-1, -1] + 1) * 10 > len(points) or len(faces) < 2:
        return False
    corners = points[faces]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    return bool(edges[-1] > FAR_REACHING * edges[:-1].max())
