"""The meshes of a PLY, OBJ or STL, parsed by trimesh without its clean-up.

Its log is silent meanwhile, because it names what is in the file, and it gets no other file than those it is given.
It takes 0.4 s to load, so scan files that hold nothing but arrays are read without it (plain_meshes.py).
"""

import logging
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np
import trimesh
from trimesh.constants import log
from trimesh.resolvers import Resolver

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.formats.obj import uniform_text
from breastrig.scan.formats.texture import LEFT_OUT, TURNED, is_turned, plain_picture
from breastrig.scan.limits import MATERIAL_FILE_BYTES, MATERIALS
from breastrig.scan.piece import Piece, Pieces

MISSING = "A picture or material file that the scan names is not beside it, and the scan is shown without it."


def library_pieces(data: bytes, kind: str, files: Mapping[str, bytes], texture: bool) -> Pieces:
    """What a ply, obj or stl file holds; `files` are those that it may name.

    Raises BadScan, TooLarge, or whatever a parser of damaged bytes raises.
    """
    resolver = _Files(files)
    with _quiet():
        stream = trimesh.util.wrap_as_stream(data)
        scene = trimesh.load_scene(stream, file_type=kind, resolver=resolver, process=False)
        pieces, has_points = _taken(scene, resolver if texture else None)
    if resolver.too_large is not None:
        raise resolver.too_large
    return Pieces(tuple(pieces), has_points, resolver.notes() if texture else ())


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
        self._refused = self._missing = self._turned = False

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
        self._turned |= is_turned(content)
        return picture

    def notes(self) -> tuple[str, ...]:
        """What became of the files that were asked for."""
        found = ((self._refused, LEFT_OUT), (self._missing, MISSING), (self._turned, TURNED))
        return tuple(note for is_so, note in found if is_so)

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
