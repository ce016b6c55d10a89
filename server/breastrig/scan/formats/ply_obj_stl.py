"""The meshes of an uploaded PLY, OBJ or STL.

trimesh does the parsing (without its clean-up), behind checks of the sizes that the file announces and of the files
that it names; its log is silent meanwhile, because it names what is in the file.  It takes what is there and leaves
the rest without a word, so the triangles that it found are counted against those that the file promises.
"""

import logging
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import trimesh
from trimesh.constants import log
from trimesh.resolvers import Resolver

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadInput, BadScan, TooLarge
from breastrig.scan.file_type import BINARY_STL_HEADER, BINARY_STL_TRIANGLE, is_binary_stl
from breastrig.scan.formats.obj import check_end, check_work, polygons, uniform_text
from breastrig.scan.formats.ply import as_binary, ply_header, text_rows
from breastrig.scan.formats.texture import LEFT_OUT, plain_picture
from breastrig.scan.limits import MATERIAL_FILE_BYTES, MATERIALS, STL_SOLIDS, TRIANGLES, VERTICES
from breastrig.scan.piece import SEVERAL, Piece, Pieces

MISSING = "A picture or material file that the scan names is not beside it, and the scan is shown without it."


def mesh_pieces(data: bytes, kind: str, files: Mapping[str, bytes], texture: bool) -> Pieces:
    """What a ply, obj or stl file holds; `files` are those that it may name.

    Raises BadScan, or TooLarge when a limit is passed, each with a sentence.
    """
    data, promised, notes = {"ply": _ply, "obj": _obj, "stl": _stl}[kind](data)
    resolver = _Files(files)
    try:
        with _quiet():
            stream = trimesh.util.wrap_as_stream(data)
            scene = trimesh.load_scene(stream, file_type=kind, resolver=resolver, process=False)
            pieces, has_points = _taken(scene, resolver if texture else None)
    except MemoryError as error:
        raise TooLarge("Reading this scan needs more memory than there is; simplify it first.") from error
    except BadInput:
        raise
    except Exception as error:  # a parser of untrusted bytes can raise anything
        raise damaged(kind) from error
    if resolver.too_large is not None:
        raise resolver.too_large
    if pieces and sum(len(piece.faces) for piece in pieces) < promised:
        raise damaged(kind)
    if kind == "obj" and pieces:
        check_end(data, sum(len(piece.vertices) for piece in pieces))
    if kind == "stl" and pieces:
        pieces = [Piece(*_corners_joined(np.concatenate([piece.vertices[piece.faces] for piece in pieces])))]
    return Pieces(tuple(pieces), has_points, (*notes, *resolver.notes()) if texture else ())


def damaged(kind: str) -> BadScan:
    """The sentence for a file that breaks off or contradicts itself."""
    return BadScan(f"This {kind.upper()} file is damaged or cut off and cannot be read; export it again.")


class _Checked(NamedTuple):
    """A file that may be given to the library."""

    data: bytes
    triangles: int  # that it promises; polygons with more corners become several
    notes: tuple[str, ...] = ()


def _ply(data: bytes) -> _Checked:
    """With a header of our own."""
    try:
        header = ply_header(data)
    except (ValueError, IndexError) as error:
        raise damaged("ply") from error
    _check_sizes(header.count("face"), max(element.count for element in header.elements))
    if header.entries > len(data) - header.size:  # each takes a byte at least
        raise damaged("ply")
    notes = (SEVERAL,) if len(header.pictures) > 1 else ()
    if header.form != "ascii":
        return _Checked(header.written() + data[header.size :], header.count("face"), notes)
    rows = text_rows(data, header)
    if rows is None:
        raise damaged("ply")
    form, body = as_binary(rows, header) or ("ascii", b"\n".join([*rows, b""]))
    return _Checked(replace(header, form=form).written() + body, header.count("face"), notes)


def _obj(data: bytes) -> _Checked:
    """As uniform text."""
    data = uniform_text(data)
    faces = polygons(data)
    _check_sizes(faces, data.count(b"\nv "))
    check_work(data)
    return _Checked(data, faces)


def _stl(data: bytes) -> _Checked:
    """As it is; a text with plain line ends."""
    if is_binary_stl(data):
        triangles = (len(data) - BINARY_STL_HEADER) // BINARY_STL_TRIANGLE
        _check_sizes(triangles, 0)
        return _Checked(data, triangles)
    data = data.replace(b"\r", b"\n")
    text = data.lower()
    triangles, ends = text.count(b"endfacet"), text.count(b"endsolid")
    _check_sizes(triangles, 0)
    if ends > STL_SOLIDS:
        raise TooLarge(f"This STL file has more than the {STL_SOLIDS} parts allowed; join them.")
    if ends == 0 or text.rfind(b"endsolid") < text.rfind(b"endfacet"):
        raise damaged("stl")
    return _Checked(data, triangles)


def _check_sizes(triangles: int, vertices: int) -> None:
    """Sizes that the file itself announces, before anything of that size is allocated."""
    if triangles > TRIANGLES or vertices > VERTICES:
        raise TooLarge(f"This scan has more than the {TRIANGLES:,} triangles allowed; simplify it first.")


@contextmanager
def _quiet() -> Iterator[None]:
    """No warnings and no log of the library."""
    nothing = _Nothing()
    log.addFilter(nothing)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            yield
    finally:
        log.removeFilter(nothing)


class _Nothing(logging.Filter):
    def filter(self, record: logging.LogRecord) -> bool:
        return False


class _Files(Resolver):  # type: ignore[misc]
    """The only files that a mesh can name: those beside it in the same zip or folder, by their plain names."""

    def __init__(self, files: Mapping[str, bytes]) -> None:
        self._files = files
        self._names = {name.lower(): name for name in files}
        self.pictures: dict[str, bytes] = {}  # those asked for and given, without what is not picture
        self.too_large: TooLarge | None = None  # kept, because the library swallows what is raised here
        self._refused = self._missing = False

    def get(self, key: str) -> bytes:
        name = plain_name(key)
        if name in self.pictures:
            return self.pictures[name]
        if name not in self._names:
            self._missing = True
            raise KeyError(name)
        content = self._files[self._names[name]]
        try:
            if name.endswith(".mtl"):
                return _material(content)
            picture = plain_picture(content)
        except TooLarge as error:
            self.too_large = error
            raise KeyError(name) from error
        if picture is None:
            self._refused = True
            raise KeyError(name)
        self.pictures[name] = picture
        return picture

    def notes(self) -> tuple[str, ...]:
        """What became of the files that were asked for."""
        return tuple(note for found, note in ((self._refused, LEFT_OUT), (self._missing, MISSING)) if found)

    def picture_of(self, image: Any) -> bytes | None:
        """The bytes behind a picture that the library has opened; it makes some up where there is none."""
        name = plain_name(image.info.get("file_path", ""))
        if name not in self.pictures and len(self.pictures) == 1:
            return next(iter(self.pictures.values()))
        return self.pictures.get(name)

    def keys(self) -> Iterator[str]:
        return iter(self._names)

    def write(self, name: str, data: Any) -> None:
        raise NotImplementedError

    def namespaced(self, namespace: str) -> "_Files":
        return self


def plain_name(key: object) -> str:
    """The last part of a path as it is written in a file, for looking it up."""
    return str(key).strip().replace("\\", "/").rsplit("/", 1)[-1].lower()


def _material(content: bytes) -> bytes:
    """An MTL in UTF-8; TooLarge when it has more materials than any scan."""
    words = content[:MATERIAL_FILE_BYTES].lower()
    if len(content) > MATERIAL_FILE_BYTES or max(words.count(b"newmtl"), words.count(b"map_kd")) > MATERIALS:
        raise TooLarge(f"The MTL file has more than the {MATERIALS} materials allowed; join them.")
    return uniform_text(content)


def _taken(scene: trimesh.Scene, resolver: _Files | None) -> tuple[list[Piece], bool]:
    """The meshes that the library found, and whether it found points without triangles."""
    pieces, has_points = [], False
    for mesh in scene.geometry.values():
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            vertices, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)
            if faces.min() < 0 or faces.max() >= len(vertices):
                raise BadScan("The triangles of this scan name vertices that do not exist; export it again.")
            pieces.append(_piece(vertices, faces, mesh.visual, resolver))
        elif hasattr(mesh, "vertices") and len(mesh.vertices):
            has_points = True
    return pieces, has_points


def _piece(vertices: Array, faces: Integers, visual: Any, resolver: _Files | None) -> Piece:
    if visual.kind == "vertex":
        return Piece(vertices, faces, colours=np.asarray(visual.vertex_colors)[:, :3])
    if visual.kind != "texture" or resolver is None:
        return Piece(vertices, faces)
    material = visual.material
    image = getattr(material, "image", None) or getattr(material, "baseColorTexture", None)
    picture = None if image is None else resolver.picture_of(image)
    uv = None if visual.uv is None else np.asarray(visual.uv, np.float64)
    if picture is None or uv is None or uv.shape[0] != len(vertices):
        return Piece(vertices, faces)
    return Piece(vertices, faces, uv=uv[:, :2], picture=picture)


def _corners_joined(triangles: Array) -> tuple[Array, Integers]:
    """(V, 3) vertices and (F, 3) faces of (F, 3, 3) corners.

    An STL repeats each corner for each triangle; equal ones become one again (exactly equal, float32).
    """
    vertices = triangles.reshape(-1, 3)
    with np.errstate(over="ignore"):  # ASCII may hold larger numbers; no torso has them, which read.py says
        single = vertices.astype(np.float32) + np.float32(0.0)
    exact = single.view(np.uint32).astype(np.uint64)
    first_two = (exact[:, 0] << np.uint64(32)) | exact[:, 1]
    order = np.lexsort((exact[:, 2], first_two))
    starts = np.ones(len(order), np.bool_)
    starts[1:] = (first_two[order][1:] != first_two[order][:-1]) | (exact[order, 2][1:] != exact[order, 2][:-1])
    group = np.zeros(len(order), np.int64)
    group[order] = np.cumsum(starts) - 1
    return vertices[order[starts]], group.reshape(-1, 3)
