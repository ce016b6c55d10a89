"""A scan file -> Scan.  The door through which strangers' bytes come in.

The kind of file is decided from its bytes, limits are checked on the file's own numbers before a library
allocates anything, no other file or address is ever opened, and whatever goes wrong inside a library becomes
one plain sentence.  trimesh does the parsing (without its clean-up); what it gives back is checked again.
"""

import hashlib
import re
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.resolvers import Resolver

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadInput, BadScan, TooLarge
from breastrig.core.units import METRES_PER_UNIT
from breastrig.scan.archive import COMPANIONS, unpacked
from breastrig.scan.clean import MIN_TRIANGLES
from breastrig.scan.file_type import BINARY_STL_HEADER, BINARY_STL_TRIANGLE, file_type_of
from breastrig.scan.glb_guard import HIDDEN_COLOURS, guarded
from breastrig.scan.limits import FILE_BYTES, MEBIBYTE, TRIANGLES, VERTICES
from breastrig.scan.scan import Scan
from breastrig.scan.texture import is_picture, written_anew
from breastrig.scan.units import decide_unit, extent

BEYOND = 1e30  # no unit has such numbers; their squares are beyond single precision
PLY_HEADER_BYTES = 100_000  # a header that is longer than this is none


def read_scan(source: Path | bytes, file_type: str | None = None, units: str = "auto", texture: bool = True) -> Scan:
    """Reads PLY, OBJ, STL, GLB or a zip of one of them with its MTL and pictures.

    `file_type` is the name's ending, only used to word errors; `units` is auto or m, dm, cm, mm, in;
    `texture=False` saves the time of decoding the pictures.  Raises BadScan, TooLarge (over a limit) or
    BadSettings (no such unit), each with one sentence.
    """
    data = _bytes(source)
    siblings: Mapping[str, bytes] = {}
    if file_type is None and isinstance(source, Path):
        file_type = source.suffix
    found = file_type_of(data, file_type)
    mesh = data
    if found == "zip":
        name, files = unpacked(data)
        mesh, siblings = files[name], files
        found = file_type_of(mesh, name.rsplit(".", 1)[-1])
        if found == "zip":
            raise BadScan("This zip holds another zip; pack the mesh itself.")
    elif found in ("obj", "ply") and isinstance(source, Path) and texture:
        siblings = _Siblings(source.parent)
    parts = _parsed(mesh, found, siblings, texture)
    _check(parts)
    unit, reason = decide_unit(extent(parts.vertices[np.unique(parts.faces[:, 0])]), units)
    metres = METRES_PER_UNIT[unit]
    return Scan(
        vertices=parts.vertices * metres,
        faces=parts.faces,
        unit=unit,
        metres_per_unit=metres,
        unit_reason=reason,
        sha256=hashlib.sha256(data).hexdigest(),
        notes=tuple(parts.notes),
        colours=parts.colours,
        uv=parts.uv if parts.texture is not None else None,
        texture=parts.texture,
    )


class _Parts:
    """What parsing collects."""

    def __init__(self) -> None:
        self.vertices: Array = np.zeros((0, 3))
        self.faces: Integers = np.zeros((0, 3), np.int64)
        self.colours: NDArray[np.uint8] | None = None
        self.uv: Array | None = None
        self.texture: bytes | None = None
        self.notes: list[str] = []
        self.has_points = False


class _Files(Resolver):  # type: ignore[misc]
    """The only files that a mesh can name: those beside it in the same zip or folder, by their plain names."""

    def __init__(self, files: Mapping[str, bytes]) -> None:
        self._files = files
        self._names = {name.lower(): name for name in files}
        self.delivered = False  # a picture was asked for and given
        self.refused = False  # a picture that is none was asked for
        self.too_large: TooLarge | None = None  # kept, because the library swallows what is raised here

    def get(self, key: str) -> bytes:
        name = str(key).strip().replace("\\", "/").rsplit("/", 1)[-1].lower()
        content = self._files[self._names[name]]
        if name.endswith(".mtl"):
            return content
        try:
            if is_picture(content):
                self.delivered = True
                return content
        except TooLarge as error:
            self.too_large = error
        self.refused = True
        raise KeyError(name)

    def keys(self) -> Iterator[str]:
        return iter(self._names)

    def write(self, name: str, data: Any) -> None:
        raise NotImplementedError

    def namespaced(self, namespace: str) -> "_Files":
        return self


class _Siblings(Mapping[str, bytes]):
    """Materials and pictures in the folder of a file, read when asked for, never outside that folder."""

    def __init__(self, folder: Path) -> None:
        self._paths = {
            path.name: path
            for path in folder.iterdir()
            if path.suffix.lower().lstrip(".") in COMPANIONS and path.is_file() and not path.is_symlink()
        }

    def __getitem__(self, name: str) -> bytes:
        return _bytes(self._paths[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._paths)

    def __len__(self) -> int:
        return len(self._paths)


def _bytes(source: Path | bytes) -> bytes:
    try:
        size = len(source) if isinstance(source, bytes) else source.stat().st_size
        if size > FILE_BYTES:
            raise TooLarge(f"This file has {size // MEBIBYTE:,} MB, more than the {FILE_BYTES // MEBIBYTE} MB allowed.")
        return source if isinstance(source, bytes) else source.read_bytes()
    except OSError as error:
        raise BadScan(f"The file {source!s} cannot be read ({error.strerror}); check the name.") from error


def _parsed(data: bytes, kind: str, files: Mapping[str, bytes], texture: bool) -> _Parts:
    parts = _Parts()
    if kind == "glb":
        data, notes = guarded(data)
        parts.notes += notes
    else:
        _check_announced_sizes(data, kind)
    resolver = _Files(files if texture else {})
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            stream = trimesh.util.wrap_as_stream(data)
            scene = trimesh.load_scene(stream, file_type=kind, resolver=resolver, process=False)
            # where there is no picture the library makes one up, so what it has is believed only if we gave it
            _collect(scene, parts, textured=texture and (resolver.delivered or kind == "glb"))
    except MemoryError as error:
        raise TooLarge("Reading this scan needs more memory than there is; simplify it first.") from error
    except BadInput:
        raise
    except Exception as error:  # a parser fed by strangers can raise anything
        raise _damaged(kind) from error
    if resolver.too_large is not None:
        raise resolver.too_large
    if resolver.refused:
        parts.notes.append("The texture is neither JPEG nor PNG, or damaged, and was left out.")
    if kind == "stl" and len(parts.faces):
        parts.vertices, parts.faces = _corners_joined(parts.vertices, parts.faces)
    return parts


def _damaged(kind: str) -> BadScan:
    return BadScan(f"This {kind.upper()} file is damaged or cut off and cannot be read; export it again.")


def _check_announced_sizes(data: bytes, kind: str) -> None:
    """Sizes that the file itself announces, before anything of that size is allocated."""
    triangles = vertices = 0
    if kind == "ply":
        header = data[:PLY_HEADER_BYTES].split(b"end_header", 1)
        if len(header) == 1:
            raise _damaged(kind)
        announced = {name: int(count[:18]) for name, count in re.findall(rb"element\s+(\w+)\s+(\d+)", header[0])}
        triangles, vertices = announced.get(b"face", 0), max(announced.values(), default=0)
        if len(data) - len(header[0]) < sum(announced.values()):  # each entry takes a byte at least
            raise _damaged(kind)
    elif kind == "obj":
        triangles, vertices = data.count(b"\nf"), data.count(b"\nv ")
    elif kind == "stl":
        triangles = (len(data) - BINARY_STL_HEADER) // BINARY_STL_TRIANGLE
        if data.lstrip()[:5].lower() == b"solid":
            triangles = min(triangles, data.lower().count(b"endfacet") or triangles)
    if triangles > TRIANGLES or vertices > VERTICES:
        raise TooLarge(f"This scan has more than the {TRIANGLES:,} triangles allowed; simplify it first.")


def _collect(scene: trimesh.Scene, parts: _Parts, textured: bool) -> None:
    """Joins the scene's meshes, each where its node puts it, with the colours or the texture that all share."""
    meshes = []
    order = {name: index for index, name in enumerate(scene.geometry)}
    placed = [(order[scene.graph[node][1]], str(node), scene.graph[node]) for node in scene.graph.nodes_geometry]
    for _, _, (transform, name) in sorted(placed, key=lambda place: place[:2]):  # the library's own order varies
        mesh = scene.geometry[name]
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            meshes.append((mesh, np.asarray(transform, np.float64)))
        elif hasattr(mesh, "vertices") and len(mesh.vertices):
            parts.has_points = True
    if not meshes:
        return
    vertices, faces, offset = [], [], 0
    for mesh, transform in meshes:
        own = np.asarray(mesh.vertices, np.float64)
        triangles = np.asarray(mesh.faces, np.int64)
        if triangles.min() < 0 or triangles.max() >= len(own):
            raise BadScan("The triangles of this scan name vertices that do not exist; export it again.")
        if not np.array_equal(transform, np.eye(4)):
            own = own @ transform[:3, :3].T + transform[:3, 3]
            if np.linalg.det(transform[:3, :3]) < 0:
                triangles = triangles[:, ::-1]
        vertices.append(own)
        faces.append(triangles + offset)
        offset += len(own)
    parts.vertices, parts.faces = np.concatenate(vertices), np.concatenate(faces)
    visuals = [mesh.visual for mesh, _ in meshes]
    linear = [mesh.vertex_attributes.get(HIDDEN_COLOURS) for mesh, _ in meshes]
    if textured and all(visual.kind == "texture" for visual in visuals):
        _collect_texture(visuals, parts)
    if parts.texture is None and all(colours is not None for colours in linear):
        parts.colours = np.concatenate([_srgb(np.asarray(colours)) for colours in linear])
    elif parts.texture is None and all(visual.kind == "vertex" for visual in visuals):
        parts.colours = np.concatenate([np.asarray(visual.vertex_colors)[:, :3] for visual in visuals])


def _collect_texture(visuals: list[Any], parts: _Parts) -> None:
    """Keeps the texture when one picture serves all meshes; scanner apps split a mesh but not its picture."""
    pictures: list[Any] = [
        getattr(visual.material, "baseColorTexture", None) or getattr(visual.material, "image", None)
        for visual in visuals
    ]
    if any(picture is None or visual.uv is None for picture, visual in zip(pictures, visuals, strict=True)):
        return
    if len({id(picture) for picture in pictures}) > 1 and len({picture.tobytes() for picture in pictures}) > 1:
        parts.notes.append("The scan has several textures and is shown without them.")
        return
    uv = np.concatenate([np.asarray(visual.uv, np.float64)[:, :2] for visual in visuals])
    if len(uv) != len(parts.vertices) or not np.isfinite(uv).all():
        return
    parts.texture = written_anew(pictures[0])
    parts.uv = uv
    if parts.texture is None:
        parts.notes.append("The texture is damaged and was left out.")


def _srgb(linear: NDArray[Any]) -> NDArray[np.uint8]:
    """(V, 3) sRGB of linear light as glTF stores it: floats from 0 to 1, or whole numbers up to their maximum."""
    full = 1.0 if linear.dtype.kind == "f" else float(np.iinfo(linear.dtype).max)
    light = np.clip(np.nan_to_num(linear[:, :3].astype(np.float64) / full), 0.0, 1.0)
    encoded = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1.0 / 2.4) - 0.055)
    return np.asarray(np.round(255.0 * encoded).astype(np.uint8))


def _corners_joined(vertices: Array, faces: Integers) -> tuple[Array, Integers]:
    """An STL repeats each corner for each triangle; equal ones become one again (exactly equal, float32)."""
    with np.errstate(over="ignore"):  # ASCII may hold larger numbers; no torso has them, which _check says
        single = vertices.astype(np.float32) + np.float32(0.0)
    exact = single.view(np.uint32).astype(np.uint64)
    first_two = (exact[:, 0] << np.uint64(32)) | exact[:, 1]
    order = np.lexsort((exact[:, 2], first_two))
    starts = np.ones(len(order), np.bool_)
    starts[1:] = (first_two[order][1:] != first_two[order][:-1]) | (exact[order, 2][1:] != exact[order, 2][:-1])
    group = np.zeros(len(order), np.int64)
    group[order] = np.cumsum(starts) - 1
    return vertices[order[starts]], group[faces]


def _check(parts: _Parts) -> None:
    """What every scan must be, whatever file it came in."""
    if not len(parts.faces):
        what = "only points" if parts.has_points else "no triangles"
        raise BadScan(f"This scan has {what}; export it as a triangle mesh.")
    sound = (np.abs(parts.vertices) < BEYOND).all(axis=1)  # false for what is no number, too
    if not sound.all():
        bad = int((~sound).sum())
        which = "One vertex of this scan is" if bad == 1 else f"{bad:,} vertices of this scan are"
        raise BadScan(f"{which} not finite or far beyond all reason; repair the mesh or export it again.")
    if len(parts.faces) > TRIANGLES:
        raise TooLarge(f"This scan has more than the {TRIANGLES:,} triangles allowed; simplify it first.")
    if len(parts.faces) < MIN_TRIANGLES:
        count = "1 triangle" if len(parts.faces) == 1 else f"{len(parts.faces)} triangles"
        raise BadScan(f"This scan has only {count}, too few to show a torso; export the whole mesh.")
