"""3MF: the model of its package, with what its build puts together, colours and textures of the materials extension.

Parsed as a stream, so that a large file makes no tree; document types, which could define entities, are refused.
"""

from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers.expat import ExpatError, ParserCreate

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.formats.polygons import split
from breastrig.scan.limits import (
    GLTF_DEPTH,
    GLTF_ENTRIES,
    GLTF_PRIMITIVES,
    MATERIALS,
    TOO_MANY_TRIANGLES,
    TRIANGLES,
    VERTICES,
)
from breastrig.scan.pictures.companions import Companions
from breastrig.scan.piece import UNCOLOURED, Piece, Pieces, part

UNITS = {"micron": "mm", "millimeter": "mm", "centimeter": "cm", "inch": "in", "foot": "ft", "meter": "m"}
MICRON = 1e-3  # mm
NOT_DRAWN = ("support", "solidsupport", "other")  # types of objects that are no part of the model
OTHER_COLOURS = "Parts of this 3MF have colours of a kind that is not read here, and are shown in one colour."
ELSEWHERE = "A part of this 3MF is not in its package; export it again."
NONE = -1
ENTRIES = ("model", "object", "component", "item", "texture2d", "colorgroup", "basematerials", "texture2dgroup")


@dataclass(eq=False)
class _Object:
    """A mesh, or what it is put together from."""

    drawn: bool
    group: int  # of its colours, and the number in it
    number: int
    points: "array[float]" = field(default_factory=lambda: array("d"))
    corners: "array[int]" = field(default_factory=lambda: array("q"))
    groups: "array[int]" = field(default_factory=lambda: array("q"))  # of each triangle
    numbers: "array[int]" = field(default_factory=lambda: array("q"))  # of each corner
    components: list[dict[str, str]] = field(default_factory=list)


@dataclass(eq=False)
class _Group:
    """Colours, or places in a picture."""

    picture: str | None = None
    values: list[tuple[float, ...]] = field(default_factory=list)  # (r, g, b), or (u, v)


class _Model:
    """One part of the package."""

    def __init__(self, data: bytes) -> None:
        self.unit: str | None = None
        self.objects: dict[int, _Object] = {}
        self.groups: dict[int, _Group] = {}
        self.items: list[dict[str, str]] = []
        self._pictures: dict[int, str] = {}
        self._object = _Object(False, NONE, NONE)
        self._group = _Group()
        self._vertices = self._triangles = self._values = self._entries = 0
        parser = ParserCreate(namespace_separator=" ")
        parser.StartElementHandler = self._begin
        parser.StartDoctypeDeclHandler = self._refuse
        try:
            parser.Parse(data, True)
        except ExpatError as error:
            raise ValueError("no sound XML") from error

    def _refuse(self, *_: object) -> None:
        raise BadScan("This 3MF defines a document type, which none needs; export it again.")

    def _begin(self, tag: str, given: dict[str, str]) -> None:
        word = tag.rsplit(" ", 1)[-1]
        if word == "vertex" and "z" in given:  # those of slices have none
            self._vertices += 1
            self._object.points.extend((float(given["x"]), float(given["y"]), float(given["z"])))
            if self._vertices > VERTICES:
                raise TooLarge(TOO_MANY_TRIANGLES)
        elif word == "triangle":
            self._triangle(given)
        elif word in ("color", "base"):
            self._add_value(_colour(given.get("color" if word == "color" else "displaycolor", "")))
        elif word == "tex2coord":
            self._add_value((float(given["u"]), float(given["v"])))
        elif word in ENTRIES:
            self._entries += 1
            if self._entries > GLTF_ENTRIES:
                raise TooLarge(f"This 3MF has more than the {GLTF_ENTRIES:,} parts allowed; join them.")
            self._other(word, {name.rsplit(" ", 1)[-1]: value for name, value in given.items()})

    def _add_value(self, value: tuple[float, ...]) -> None:
        self._values += 1
        if self._values > VERTICES:
            raise TooLarge(TOO_MANY_TRIANGLES)
        self._group.values.append(value)

    def _other(self, word: str, given: dict[str, str]) -> None:
        if word == "model":
            self.unit = given.get("unit")
        elif word == "object":
            is_drawn = given.get("type", "model") not in NOT_DRAWN
            self._object = _Object(is_drawn, int(given.get("pid", NONE)), int(given.get("pindex", 0)))
            self.objects[int(given["id"])] = self._object
        elif word == "component":
            self._object.components.append(given)
        elif word == "item":
            self.items.append(given)
        elif word == "texture2d":
            self._pictures[int(given["id"])] = given["path"]
        elif word in ("colorgroup", "basematerials"):
            self._group = self.groups[int(given["id"])] = _Group()
        elif word == "texture2dgroup":
            self._group = self.groups[int(given["id"])] = _Group(self._pictures[int(given["texid"])])

    def _triangle(self, given: dict[str, str]) -> None:
        self._triangles += 1
        if self._triangles > TRIANGLES:
            raise TooLarge(TOO_MANY_TRIANGLES)
        own = self._object
        own.corners.extend((int(given["v1"]), int(given["v2"]), int(given["v3"])))
        first = int(given.get("p1", own.number))
        own.groups.append(int(given.get("pid", own.group)))
        own.numbers.extend((first, int(given.get("p2", first)), int(given.get("p3", first))))


def read_3mf(data: bytes, files: Companions, texture: bool) -> Pieces:
    """The meshes of a model's build; `data` is the package's 3dmodel.model.

    Raises BadScan, TooLarge, or ValueError where it is damaged.
    """
    package = _Package(data, files, texture)
    pieces = package.pieces()
    named = package.root.unit
    if named is not None and named not in UNITS:
        raise ValueError("an unknown unit")
    return Pieces(pieces, notes=files.notes(), unit=UNITS[named or "millimeter"], unit_by_default=named is None)


class _Package:
    """All models of a package, read when they are named."""

    def __init__(self, data: bytes, files: Companions, texture: bool) -> None:
        self.root = _Model(data)
        self._files, self._texture = files, texture
        self._models: dict[str, _Model] = {"": self.root}
        self._visits = self._triangles = self._vertices = 0

    def pieces(self) -> tuple[Piece, ...]:
        """The built items, or all objects where nothing is built."""
        items = self.root.items or [
            {"objectid": str(each)} for each, found in self.root.objects.items() if len(found.corners)
        ]
        size = np.eye(3) * (MICRON if self.root.unit == "micron" else 1.0)
        whole = (size, np.zeros(3))
        return tuple(piece for item in items for piece in self._built(item, "", whole, 1))

    def _built(self, given: dict[str, str], place: str, above: tuple[Array, Array], depth: int) -> Iterator[Piece]:
        """The pieces of what an item or a component names, moved by its own transform and by what is above it."""
        self._visits += 1
        if self._visits > GLTF_PRIMITIVES or depth > GLTF_DEPTH:
            raise TooLarge(f"This 3MF is put together from more than {GLTF_PRIMITIVES:,} parts; join them.")
        place = given.get("path", place)
        model = self._model(place)
        found = model.objects[int(given["objectid"])]
        turn, shift = _transform(given.get("transform"))
        placed = turn @ above[0], shift @ above[0] + above[1]
        for component in found.components:
            yield from self._built(component, place, placed, depth + 1)
        if len(found.corners) and found.drawn:
            self._triangles += len(found.corners) // 3
            self._vertices += len(found.points) // 3
            if self._triangles > TRIANGLES or self._vertices > VERTICES:
                raise TooLarge(TOO_MANY_TRIANGLES)
            faces = np.frombuffer(found.corners, np.int64).reshape(-1, 3)
            vertices = np.frombuffer(found.points, np.float64).reshape(-1, 3) @ placed[0] + placed[1]
            if not 0 <= faces.min() <= faces.max() < len(vertices):
                raise BadScan("The triangles of this scan name vertices that do not exist; export it again.")
            yield from self._painted(model, found, vertices, faces, bool(np.linalg.det(placed[0]) < 0.0))

    def _model(self, place: str) -> _Model:
        if place not in self._models:
            data = self._files.find(place)
            if data is None:
                raise BadScan(ELSEWHERE)
            self._models[place] = _Model(data)
        return self._models[place]

    def _painted(
        self, model: _Model, found: _Object, vertices: Array, faces: Integers, is_mirrored: bool
    ) -> Iterator[Piece]:
        """A piece for each group of colours."""
        groups, numbers = np.frombuffer(found.groups, np.int64), np.frombuffer(found.numbers, np.int64).reshape(-1, 3)
        if is_mirrored:
            faces, numbers = faces[:, ::-1], numbers[:, ::-1]
        used = np.unique(groups)
        if len(used) > MATERIALS:
            raise TooLarge(f"This 3MF file uses more than the {MATERIALS} groups of colours allowed; join them.")
        for group in used:
            chosen = groups == group
            own = part(Piece(vertices, faces), chosen)
            yield self._in_colours(own, numbers[chosen], int(group), model)

    def _in_colours(self, piece: Piece, numbers: Integers, group: int, model: _Model) -> Piece:
        known = model.groups.get(group)
        if known is None or not known.values:
            if group != NONE:
                self._files.note(OTHER_COLOURS)
            return piece
        if not 0 <= numbers.min() <= numbers.max() < len(known.values):
            raise ValueError("a colour that is not there")
        values = np.array(known.values, np.float64)[numbers]
        picture = self._files.picture(known.picture) if known.picture and self._texture else None
        if known.picture and picture is None:
            return piece
        which, faces, split_values = split(piece.faces, values)
        if picture is not None:
            return Piece(piece.vertices[which], faces, uv=split_values, picture=picture)
        return Piece(piece.vertices[which], faces, split_values.astype(np.uint8))


def _colour(text: str) -> tuple[int, int, int]:
    """sRGB of #rrggbb or #rrggbbaa; grey where there is none."""
    if not text.startswith("#") or len(text) < 7:
        return (UNCOLOURED,) * 3
    return int(text[1:3], 16), int(text[3:5], 16), int(text[5:7], 16)


def _transform(text: str | None) -> tuple[Array, Array]:
    """((3, 3), (3,)) of a row that is multiplied from the left: place @ matrix + shift."""
    if text is None:
        return np.eye(3), np.zeros(3)
    table = np.array(text.split(), np.float64).reshape(4, 3)
    return table[:3], table[3]
