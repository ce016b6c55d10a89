"""The meshes of an uploaded .glb: nothing outside, nothing compressed, nothing endless, nothing left out in silence.

A .glb can name other files or addresses, hide its geometry in a compression (Draco's is unpacked in draco.py),
build a scene that contains itself, claim arrays of any length, or say one small mesh 300,000 times.  All of that is
found in the JSON alone, before an array is read.  Then only what the scene draws is read: positions, triangles,
colours, texture coordinates and the picture of the base colour; names, extras, animations, cameras and what no node
draws are not looked at.

Tried and dropped: trimesh's reader behind such a check.  It ignores sparse accessors and triangle fans without a word,
reads every accessor whether used or not, and needs a millisecond for each primitive.
"""

import base64
from collections.abc import Iterator, Mapping
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadScan, TooLarge
from breastrig.core.glb import split_glb
from breastrig.core.gltf_arrays import GltfArrays, entry, whole
from breastrig.geometry.rotations import rotation_from_quaternion
from breastrig.scan.formats import draco
from breastrig.scan.formats.texture import LEFT_OUT, TURNED, is_turned, plain_picture
from breastrig.scan.limits import (
    GLTF_DEPTH,
    GLTF_ENTRIES,
    GLTF_JSON_BYTES,
    GLTF_NODES,
    GLTF_PRIMITIVES,
    MEBIBYTE,
    TRIANGLES,
    VERTICES,
)
from breastrig.scan.piece import Piece, Pieces

HARMLESS = ("KHR_materials_", "KHR_texture_transform", "KHR_lights_punctual", "EXT_materials_", "KHR_mesh_quantization")
MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")
PACKED = (
    "This GLB file is compressed (meshopt); open it in the page, which unpacks it, or export it without compression."
)
PLACED_OTHERWISE = "The texture is placed by an extension that is not read here, and was left out."
POSED = "The file poses its mesh with bones or shapes, which is not followed; if it looks wrong, export the posed mesh."
POINTS, TRIANGLE_LIST, TRIANGLE_STRIP, TRIANGLE_FAN = 0, 4, 5, 6  # glTF's modes; 1 to 3 are lines
LISTS = ("nodes", "meshes", "accessors", "bufferViews", "buffers", "materials", "textures", "images", "scenes")
JSON_LENGTH_AT = 12  # bytes into the file
BROKEN = (ValueError, TypeError, KeyError, IndexError, AttributeError, RecursionError, OverflowError)


def glb_pieces(data: bytes, texture: bool) -> Pieces:
    """What the file's scene draws, in metres if the file keeps to the format.

    Raises BadScan, or TooLarge when a limit is passed, each with a sentence.
    """
    try:
        return _Drawn(_document(data), texture).pieces()
    except BROKEN as error:
        reason = str(error) if type(error) is ValueError else "its structure is broken"
        raise BadScan(f"This GLB file cannot be read: {reason}; export it again.") from error


def _document(data: bytes) -> tuple[dict[str, Any], bytes]:
    announced = int.from_bytes(data[JSON_LENGTH_AT : JSON_LENGTH_AT + 4], "little")
    if GLTF_JSON_BYTES < announced < len(data):
        raise TooLarge(
            f"This GLB file describes itself in more than {GLTF_JSON_BYTES // MEBIBYTE} MB of text; "
            "export it with its data in the binary part."
        )
    document, binary = split_glb(data)
    for name in LISTS:
        most, found = GLTF_NODES if name == "nodes" else GLTF_ENTRIES, len(document.get(name, []))
        if found > most:
            raise TooLarge(f"This GLB file has {found:,} {name}, more than the {most:,} allowed; join its meshes.")
    _check_extensions(document)
    _check_addresses(document)
    return document, binary


def _check_extensions(document: dict[str, Any]) -> None:
    used = {*document.get("extensionsUsed", []), *document.get("extensionsRequired", [])}
    if used & set(MESHOPT):
        raise BadScan(PACKED)
    for name in document.get("extensionsRequired", []):
        if not str(name).startswith((*HARMLESS, draco.EXTENSION)):
            raise BadScan("This GLB file needs a glTF extension that is not read here; export it as plain glTF 2.0.")


def _check_addresses(document: dict[str, Any]) -> None:
    for kind in ("buffers", "images"):
        for item in document.get(kind, []):
            if "uri" in item and not str(item["uri"]).startswith("data:"):
                raise BadScan("This GLB file points to other files; export it with everything inside.")


class _Drawn:
    """What the nodes of one document draw."""

    def __init__(self, content: tuple[dict[str, Any], bytes], texture: bool) -> None:
        self._document, self._binary = content
        self._texture = texture
        self._notes: list[str] = []
        self._read: dict[tuple[int, bool], NDArray[Any]] = {}
        self._pictures: dict[int, bytes | None] = {}
        self._unpacked_primitives: dict[int, dict[str, Any]] = {}  # by the identity of what the document holds
        self._arrays: GltfArrays | None = None

    def pieces(self) -> Pieces:
        placed = sorted(self._placed(), key=lambda place: place[:2])
        primitives = [entry(self._document, "meshes", mesh)["primitives"] for mesh, _, _ in placed]
        self._check_counts(primitives)
        draws = [(place[2], primitive) for place, own in zip(placed, primitives, strict=True) for primitive in own]
        self._arrays = GltfArrays(self._document, self._binary)
        with np.errstate(all="ignore"):  # infinite numbers are found afterwards, in every kind of file
            pieces = [piece for transform, drawn in draws if (piece := self._piece(drawn, transform)) is not None]
        has_points = any(
            _mode(primitive) not in (TRIANGLE_LIST, TRIANGLE_STRIP, TRIANGLE_FAN) for _, primitive in draws
        )
        return Pieces(tuple(pieces), has_points, tuple(dict.fromkeys(self._notes)))

    def _placed(self) -> Iterator[tuple[int, int, Array]]:
        """(mesh, node, 4 x 4 matrix) of each node of the scene that draws."""
        nodes = self._document.get("nodes", [])
        parents = _parents(nodes)
        scenes = self._document.get("scenes", [])
        roots = [index for index in range(len(nodes)) if index not in parents]
        if scenes:
            wanted = set(entry(self._document, "scenes", self._document.get("scene", 0)).get("nodes", []))
            roots = [index for index in roots if index in wanted]
        if nodes and not roots:
            raise ValueError("its scene is empty or contains itself")
        waiting = [(root, np.eye(4), 1) for root in roots]
        while waiting:
            index, above, depth = waiting.pop()
            if depth > GLTF_DEPTH:
                raise TooLarge(f"The scene of this GLB file is nested more than {GLTF_DEPTH} deep; join its meshes.")
            node = entry(self._document, "nodes", index)
            transform = above @ _matrix(node)
            waiting += [(child, transform, depth + 1) for child in node.get("children", [])]
            if "mesh" in node:
                mesh = entry(self._document, "meshes", node["mesh"])
                if "skin" in node or any(node.get("weights", mesh.get("weights", []))):
                    self._notes.append(POSED)
                yield node["mesh"], index, transform

    def _check_counts(self, drawn: list[list[dict[str, Any]]]) -> None:
        """The sizes that the document announces for all that is drawn: primitives, node by node."""
        pieces = sum(map(len, drawn))
        if pieces > GLTF_PRIMITIVES:
            raise TooLarge(
                f"This GLB file draws {pieces:,} pieces, more than the {GLTF_PRIMITIVES:,} allowed; join its meshes."
            )
        triangles = vertices = 0
        for primitive in chain.from_iterable(drawn):
            points = self._count(primitive["attributes"]["POSITION"])
            corners = self._count(primitive["indices"]) if "indices" in primitive else points
            triangles += corners // 3 if _mode(primitive) == TRIANGLE_LIST else corners
            vertices += points
        if triangles > TRIANGLES or vertices > VERTICES:
            raise TooLarge(f"This scan has more than the {TRIANGLES:,} triangles allowed; simplify it first.")

    def _count(self, accessor: Any) -> int:
        return whole(entry(self._document, "accessors", accessor).get("count"), "the length of an array")

    def _piece(self, primitive: dict[str, Any], transform: Array) -> Piece | None:
        mode = _mode(primitive)
        if mode not in (TRIANGLE_LIST, TRIANGLE_STRIP, TRIANGLE_FAN):
            return None
        if draco.EXTENSION in primitive.get("extensions", {}):
            primitive = self._unpacked(primitive)
        attributes = primitive["attributes"]
        vertices = self._values(attributes["POSITION"], (3,))
        corners = self._values(primitive["indices"], ()) if "indices" in primitive else np.arange(len(vertices))
        if corners.dtype.kind != "i":
            raise ValueError("its triangles are no whole numbers")
        faces = _triangles(corners, mode)
        if not len(faces):
            return None
        if not np.array_equal(transform, np.eye(4)):
            vertices = vertices @ transform[:3, :3].T + transform[:3, 3]
            if np.linalg.det(transform[:3, :3]) < 0:
                faces = faces[:, ::-1]
        colours = self._colours(attributes["COLOR_0"], len(vertices)) if "COLOR_0" in attributes else None
        uv, picture = self._painted(primitive, len(vertices))
        return Piece(vertices, faces, colours, uv, picture)

    def _unpacked(self, primitive: dict[str, Any]) -> dict[str, Any]:
        """The primitive with accessors of its own in place of those that Draco compressed."""
        key = id(primitive)
        if key not in self._unpacked_primitives:
            compressed = primitive["extensions"][draco.EXTENSION]
            arrays, faces = draco.decoded(self._content(compressed["bufferView"]))
            accessors, attributes = self._document["accessors"], dict(primitive["attributes"])
            for name, number in compressed["attributes"].items():
                if name in attributes:
                    accessor = entry(self._document, "accessors", attributes[name])
                    values = np.asarray(arrays[number]).astype(draco.KINDS[accessor["componentType"]])
                    attributes[name] = self._added(accessors, accessor, values)
            corners = self._added(accessors, {"type": "SCALAR"}, faces.ravel())
            self._unpacked_primitives[key] = {**primitive, "attributes": attributes, "indices": corners, "mode": 4}
        return self._unpacked_primitives[key]

    def _added(self, accessors: list[dict[str, Any]], like: dict[str, Any], values: NDArray[Any]) -> int:
        """The number of a new accessor with these values, which are in no buffer."""
        whole_numbers = values.dtype.kind in "iu"
        read = values.astype(np.int64 if whole_numbers else np.float64)
        if like.get("normalized") and whole_numbers:
            read = np.maximum(values / np.iinfo(values.dtype).max, -1.0)
        accessors.append({"type": like.get("type"), "count": len(values)})
        self._read[len(accessors) - 1, True], self._read[len(accessors) - 1, False] = values, read
        return len(accessors) - 1

    def _content(self, view: Any) -> bytes:
        """The bytes of a view of the binary part."""
        found = entry(self._document, "bufferViews", view)
        whole(found.get("buffer"), "a view's buffer", 1)
        start = whole(found.get("byteOffset", 0), "an offset")
        return self._binary[start : start + whole(found.get("byteLength"), "a length")]

    def _values(self, accessor: Any, shape: tuple[int, ...], stored: bool = False) -> NDArray[Any]:
        """(N, *shape) of an accessor, which many primitives may share."""
        assert self._arrays is not None
        key = whole(accessor, "an accessor's number"), stored
        if key not in self._read:
            self._read[key] = self._arrays.stored(accessor) if stored else self._arrays.read(accessor)
        values = self._read[key]
        if values.shape[1:] != shape:
            raise ValueError("an array has the wrong number of columns")
        return values

    def _colours(self, accessor: Any, vertices: int) -> NDArray[np.uint8] | None:
        columns = entry(self._document, "accessors", accessor).get("type") == "VEC4"
        linear = self._values(accessor, (4 if columns else 3,), stored=True)
        return _srgb(linear) if len(linear) == vertices else None

    def _painted(self, primitive: dict[str, Any], vertices: int) -> tuple[Array | None, bytes | None]:
        """((V, 2) texture coordinates from the lower left, the picture) where the primitive has both."""
        if not self._texture or "material" not in primitive:
            return None, None
        material = entry(self._document, "materials", primitive["material"])
        glossy = material.get("extensions", {}).get("KHR_materials_pbrSpecularGlossiness", {})
        painted = material.get("pbrMetallicRoughness", {}).get("baseColorTexture") or glossy.get("diffuseTexture")
        if painted is None:
            return None, None
        if "KHR_texture_transform" in painted.get("extensions", {}):
            self._notes.append(PLACED_OTHERWISE)
            return None, None
        name = f"TEXCOORD_{whole(painted.get('texCoord', 0), 'a texture coordinate')}"
        texture = entry(self._document, "textures", painted.get("index"))
        picture = self._picture(texture["source"]) if "source" in texture else None
        if picture is None:
            self._notes.append(LEFT_OUT)
        if picture is None or name not in primitive["attributes"]:
            return None, None
        uv = self._values(primitive["attributes"][name], (2,)).astype(np.float64)
        return (np.column_stack([uv[:, 0], 1.0 - uv[:, 1]]), picture) if len(uv) == vertices else (None, None)

    def _picture(self, index: Any) -> bytes | None:
        """The bytes of an image that is a JPEG or PNG."""
        if index not in self._pictures:
            image = entry(self._document, "images", index)
            if "uri" in image:
                content = base64.b64decode(image["uri"].split(",", 1)[1])
            else:
                content = self._content(image["bufferView"])
            self._pictures[index] = plain_picture(content)
            if self._pictures[index] is not None and is_turned(content):
                self._notes.append(TURNED)
        return self._pictures[index]


def _mode(primitive: dict[str, Any]) -> Any:
    return primitive.get("mode", TRIANGLE_LIST)


def _parents(nodes: list[Any]) -> Mapping[int, int]:
    """Child -> parent.  Nodes must form trees: one with two parents could be its own ancestor."""
    parents: dict[int, int] = {}
    for index, node in enumerate(nodes):
        for child in node.get("children", []):
            if whole(child, "a node's number", len(nodes)) in parents or child == index:
                raise ValueError("its scene is no tree")
            parents[child] = index
    return parents


def _matrix(node: dict[str, Any]) -> Array:
    """(4, 4) of a node in its parent."""
    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    matrix = np.eye(4)
    if "rotation" in node:
        quaternion = np.array(node["rotation"], np.float64).reshape(4)
        length = np.linalg.norm(quaternion)
        if length > 0.0:
            matrix[:3, :3] = rotation_from_quaternion(quaternion / length)
    if "scale" in node:
        matrix[:3, :3] *= np.array(node["scale"], np.float64).reshape(3)
    if "translation" in node:
        matrix[:3, 3] = np.array(node["translation"], np.float64).reshape(3)
    return matrix


def _triangles(corners: Integers, mode: int) -> Integers:
    """(F, 3) of the corners of a list, a strip (every other triangle runs the other way round) or a fan."""
    if mode == TRIANGLE_LIST:
        if len(corners) % 3:
            raise ValueError("its last triangle is not whole")
        return corners.reshape(-1, 3)
    if len(corners) < 3:
        return np.zeros((0, 3), np.int64)
    if mode == TRIANGLE_FAN:
        return np.column_stack([np.full(len(corners) - 2, corners[0]), corners[1:-1], corners[2:]])
    faces = np.column_stack([corners[:-2], corners[1:-1], corners[2:]])
    faces[1::2] = faces[1::2, [1, 0, 2]]
    return faces


def _srgb(linear: NDArray[Any]) -> NDArray[np.uint8]:
    """(V, 3) sRGB of linear light as glTF stores it: floats from 0 to 1, or whole numbers up to their maximum."""
    full = 1.0 if linear.dtype.kind == "f" else float(np.iinfo(linear.dtype).max)
    light = np.clip(np.nan_to_num(linear[:, :3].astype(np.float64) / full), 0.0, 1.0)
    encoded = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1.0 / 2.4) - 0.055)
    return np.asarray(np.round(255.0 * encoded).astype(np.uint8))
