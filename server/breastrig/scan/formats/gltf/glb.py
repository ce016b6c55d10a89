"""The meshes of an uploaded .glb or .gltf, checked in its JSON before any array is read (docs/decisions/0017).

Refused: other addresses, scenes that contain themselves, lengths beyond the limits.  Read: what the scene draws, with
positions, triangles, colours, texture coordinates and the picture of the skin, also compressed by Draco or meshopt;
other files only from its own folder or zip.
"""

import re
from base64 import b64decode
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import chain
from typing import Any
from urllib.parse import unquote_to_bytes

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array, Integers
from breastrig.core.errors import BadScan, TooLarge
from breastrig.core.glb import parse_document, split_glb
from breastrig.core.gltf_arrays import DTYPES, GltfArrays, entry, whole
from breastrig.geometry.rotations import rotation_from_quaternion
from breastrig.scan.formats.gltf.compressed import DRACO, MESHOPT, draco_mesh, unpacked_views
from breastrig.scan.formats.gltf.pose import joint_matrices, skinned
from breastrig.scan.formats.polygons import strip
from breastrig.scan.limits import (
    GLTF_DEPTH,
    GLTF_ENTRIES,
    GLTF_JSON_BYTES,
    GLTF_NODES,
    GLTF_PRIMITIVES,
    MEBIBYTE,
    TOO_MANY_TRIANGLES,
    TRIANGLES,
    VERTICES,
)
from breastrig.scan.pictures.companions import Companions
from breastrig.scan.pictures.texture import LEFT_OUT, TURNED, is_turned, plain_picture
from breastrig.scan.piece import Piece, Pieces, srgb_bytes
from breastrig.scan.unscaled import names_unscaled

HARMLESS = (
    *("KHR_materials_", "EXT_materials_", "KHR_lights_punctual", "KHR_mesh_quantization"),
    *("KHR_texture_", "EXT_texture_", "MSFT_texture_"),  # a picture that cannot be read is left out, and it is said
)
GLOSSY = "KHR_materials_pbrSpecularGlossiness"
PICTURE_SOURCES = ("EXT_texture_webp", "EXT_texture_avif")
UNPLACED = "The scan has a picture but not where it lies on the skin, and is shown without it."
ELSEWHERE = (
    "This {kind} keeps its data in another file, which is not beside it; pack both in a zip, or export one .glb with "
    "everything inside."
)
POINTS, TRIANGLE_LIST, TRIANGLE_STRIP, TRIANGLE_FAN = 0, 4, 5, 6  # glTF's modes; 1 to 3 are lines
TOO_LONG = (
    f"This {{kind}} describes itself in more than {GLTF_JSON_BYTES // MEBIBYTE} MB of text; "
    "export it as a .glb with its data in the binary part."
)
LISTS = ("nodes", "meshes", "accessors", "bufferViews", "buffers", "materials", "textures", "images", "scenes")
JSON_LENGTH_AT = 12  # bytes into the file
INSIDE = re.compile(rb'"data:([^"]{200,})"')  # content within the text of a .gltf
BROKEN = (ValueError, TypeError, KeyError, IndexError, AttributeError, RecursionError, OverflowError)


def glb_pieces(data: bytes, files: Companions, texture: bool) -> Pieces:
    """The meshes of the file's scene, in metres if the file keeps to the format; `data` is a .glb or a .gltf.

    Raises BadScan, or TooLarge when a limit is passed, each with a sentence.
    """
    kind = "GLB file" if data.startswith(b"glTF") else ".gltf"
    try:
        document, buffers = _document(data, files, kind)
        pieces = _Drawn((document, buffers), files, texture).pieces()
        asset = document.get("asset")
        return replace(pieces, is_unscaled=isinstance(asset, dict) and names_unscaled([asset.get("generator")]))
    except BROKEN as error:
        reason = str(error) if type(error) is ValueError else "its structure is broken"
        raise BadScan(f"This {kind} cannot be read: {reason}; export it again.") from error


def _document(data: bytes, files: Companions, kind: str) -> tuple[dict[str, Any], bytes]:
    """(document, all that its buffers hold as one)."""
    inside: list[bytes] = []
    if data.startswith(b"glTF"):
        announced = int.from_bytes(data[JSON_LENGTH_AT : JSON_LENGTH_AT + 4], "little")
        if GLTF_JSON_BYTES < announced < len(data):
            raise TooLarge(TOO_LONG.format(kind=kind))
        document, binary = split_glb(data)
    else:

        def taken(found: re.Match[bytes]) -> bytes:
            inside.append(found[1])
            return b'"data:%d"' % (len(inside) - 1)

        text = INSIDE.sub(taken, data)
        if len(text) > GLTF_JSON_BYTES:
            raise TooLarge(TOO_LONG.format(kind=kind))
        document, binary = parse_document(text), b""
    for name in LISTS:
        most, found = GLTF_NODES if name == "nodes" else GLTF_ENTRIES, len(document.get(name, []))
        if found > most:
            raise TooLarge(f"This {kind} has {found:,} {name}, more than the {most:,} allowed; join its meshes.")
    for name in document.get("extensionsRequired", []):
        if not str(name).startswith((*HARMLESS, DRACO, *MESHOPT)):
            raise BadScan(f"This {kind} needs a glTF extension that is not read here; export it as plain glTF 2.0.")
    _bring_pictures(document, inside)
    return document, _joined_buffers(document, binary, inside, files, kind)


def _content(uri: str, inside: list[bytes]) -> bytes:
    """The decoded content of a data address; ValueError when it cannot be decoded."""
    text = uri.removeprefix("data:")
    coded = inside[int(text)].replace(b"\\/", b"/") if text.isdigit() else text.encode()
    head, comma, content = coded.partition(b",")
    if not comma:
        raise ValueError("a data address in it cannot be decoded")
    return b64decode(content, validate=True) if head.endswith(b";base64") else unquote_to_bytes(content)


def _bring_pictures(document: dict[str, Any], inside: list[bytes]) -> None:
    for image in document.get("images", []):
        if str(image.get("uri", "")).startswith("data:"):
            image["content"] = _content(image["uri"], inside)


def _joined_buffers(
    document: dict[str, Any], binary: bytes, inside: list[bytes], files: Companions, kind: str
) -> bytes:
    """All buffers joined into one; views are moved accordingly."""
    parts: list[bytes] = []
    for index, buffer in enumerate(document.get("buffers", [])):
        uri = buffer.pop("uri", None)
        if uri is None:
            parts.append(binary if index == 0 else b"")
        elif str(uri).startswith("data:"):
            parts.append(_content(uri, inside))
        else:
            found = None if "://" in str(uri) else files.find(str(uri))
            if found is None:
                raise BadScan(ELSEWHERE.format(kind=kind))
            parts.append(found)
    if len(parts) < 2:
        return b"".join(parts)
    starts = np.cumsum([0, *(len(part) for part in parts)])
    views = document.get("bufferViews", [])
    for view in chain(views, *(each.get("extensions", {}).values() for each in views)):
        if "buffer" in view:
            number = whole(view["buffer"], "a view's buffer", len(parts))
            offset = whole(view.get("byteOffset", 0), "an offset")
            if offset + whole(view.get("byteLength"), "a length") > len(parts[number]) and not view.get("extensions"):
                raise ValueError("an accessor reaches beyond the end of its buffer")
            view |= {"buffer": 0, "byteOffset": offset + int(starts[number])}
    document["buffers"] = [{"byteLength": int(starts[-1])}]
    return b"".join(parts)


class _Drawn:
    """The meshes that one document's scene draws."""

    def __init__(self, content: tuple[dict[str, Any], bytes], files: Companions, texture: bool) -> None:
        self._document, self._binary = content
        self._files, self._texture = files, texture
        self._notes: list[str] = []
        self._read: dict[tuple[int, bool], NDArray[Any]] = {}
        self._pictures: dict[int, bytes | None] = {}
        self._unpacked_primitives: dict[int, dict[str, Any]] = {}  # by the identity of what the document holds
        self._arrays: GltfArrays | None = None
        self._world: dict[int, Array] = {}  # (4, 4) of each node
        self._skins: dict[int, Array] = {}  # (J, 4, 4) of each skin that is drawn

    def pieces(self) -> Pieces:
        placed = sorted(self._placed())
        primitives = [entry(self._document, "meshes", mesh)["primitives"] for mesh, _ in placed]
        shapes = [self._shapes(*place) for place in placed]
        self._check_counts(primitives, shapes)
        draws = [(node, primitive) for (_, node), own in zip(placed, primitives, strict=True) for primitive in own]
        self._binary = unpacked_views(self._document, self._binary)
        self._arrays = GltfArrays(self._document, self._binary)
        with np.errstate(all="ignore"):  # infinite numbers are found afterwards, in every kind of file
            pieces = [piece for node, drawn in draws if (piece := self._piece(drawn, node)) is not None]
        has_points = any(
            _mode(primitive) not in (TRIANGLE_LIST, TRIANGLE_STRIP, TRIANGLE_FAN) for _, primitive in draws
        )
        return Pieces(tuple(pieces), has_points, tuple(dict.fromkeys((*self._notes, *self._files.notes()))))

    def _placed(self) -> Iterator[tuple[int, int]]:
        """(mesh, node) of each node of the scene that draws; places all nodes, for joints may be elsewhere."""
        nodes = self._document.get("nodes", [])
        parents = _parents(nodes)
        scenes = self._document.get("scenes", [])
        roots = [index for index in range(len(nodes)) if index not in parents]
        wanted = set(roots)
        if scenes:
            wanted &= set(entry(self._document, "scenes", self._document.get("scene", 0)).get("nodes", []))
        if nodes and not wanted:
            raise ValueError("its scene is empty or contains itself")
        waiting = [(root, np.eye(4), 1, root in wanted) for root in roots]
        while waiting:
            index, above, depth, is_shown = waiting.pop()
            if depth > GLTF_DEPTH:
                raise TooLarge(f"The scene of this GLB file is nested more than {GLTF_DEPTH} deep; join its meshes.")
            node = entry(self._document, "nodes", index)
            self._world[index] = above @ _matrix(node)
            waiting += [(child, self._world[index], depth + 1, is_shown) for child in node.get("children", [])]
            if "mesh" in node and is_shown:
                yield whole(node["mesh"], "a mesh's number"), index

    def _shapes(self, mesh: int, node: int) -> dict[int, float]:
        """Share of each shape (morph target) that the node, or else its mesh, asks for."""
        own = self._document["nodes"][node].get("weights", entry(self._document, "meshes", mesh).get("weights", []))
        return {number: float(share) for number, share in enumerate(own) if share}

    def _check_counts(self, drawn: list[list[dict[str, Any]]], shapes: list[dict[int, float]]) -> None:
        """Checks the announced sizes of everything that is drawn: primitives, node by node, with their shapes."""
        pieces = sum(map(len, drawn))
        if pieces > GLTF_PRIMITIVES:
            raise TooLarge(
                f"This GLB file draws {pieces:,} pieces, more than the {GLTF_PRIMITIVES:,} allowed; join its meshes."
            )
        triangles = vertices = 0
        each = (
            (primitive, len(own)) for primitives, own in zip(drawn, shapes, strict=True) for primitive in primitives
        )
        for primitive, shaped in each:
            points = self._count(primitive["attributes"]["POSITION"])
            corners = self._count(primitive["indices"]) if "indices" in primitive else points
            triangles += corners // 3 if _mode(primitive) == TRIANGLE_LIST else corners
            vertices += points * (1 + min(shaped, len(primitive.get("targets", []))))
        if triangles > TRIANGLES or vertices > VERTICES:
            raise TooLarge(TOO_MANY_TRIANGLES)

    def _count(self, accessor: Any) -> int:
        return whole(entry(self._document, "accessors", accessor).get("count"), "the length of an array")

    def _piece(self, primitive: dict[str, Any], node: int) -> Piece | None:
        mode = _mode(primitive)
        if mode not in (TRIANGLE_LIST, TRIANGLE_STRIP, TRIANGLE_FAN):
            return None
        if DRACO in primitive.get("extensions", {}):
            primitive = self._unpacked(primitive)
        attributes = primitive["attributes"]
        vertices = self._values(attributes["POSITION"], (3,)).astype(np.float64)  # quantised ones are whole numbers
        corners = self._values(primitive["indices"], ()) if "indices" in primitive else np.arange(len(vertices))
        if corners.dtype.kind != "i":
            raise ValueError("its triangles are no whole numbers")
        faces = _triangles(corners, mode)
        if not len(faces):
            return None
        vertices, is_mirrored = self._where(self._shaped(vertices, primitive, node), attributes, node)
        if is_mirrored:
            faces = faces[:, ::-1]
        colours = self._colours(attributes["COLOR_0"], len(vertices)) if "COLOR_0" in attributes else None
        uv, picture = self._painted(primitive, len(vertices))
        return Piece(vertices, faces, colours, uv, picture, self._tint(primitive))

    def _shaped(self, vertices: Array, primitive: dict[str, Any], node: int) -> Array:
        """(V, 3) with the shapes that the node gives its mesh."""
        targets = primitive.get("targets", [])
        for number, share in self._shapes(self._document["nodes"][node]["mesh"], node).items():
            if number < len(targets) and "POSITION" in targets[number]:
                offsets = self._values(targets[number]["POSITION"], (3,))
                if len(offsets) != len(vertices):
                    raise ValueError("one of its shapes has another number of vertices")
                vertices = vertices + share * offsets
        return vertices

    def _where(self, vertices: Array, attributes: dict[str, Any], node: int) -> tuple[Array, bool]:
        """((V, 3) in the scene, whether mirrored there): placed by the joints of its skin, else by the node."""
        skin = self._document["nodes"][node].get("skin")
        if skin is not None and "JOINTS_0" in attributes:
            sets = [number for number in (0, 1) if f"JOINTS_{number}" in attributes]
            joints = np.hstack([self._values(attributes[f"JOINTS_{number}"], (4,)) for number in sets])
            weights = np.hstack([self._values(attributes[f"WEIGHTS_{number}"], (4,)) for number in sets])
            if joints.dtype.kind != "i":
                raise ValueError("its joints are no whole numbers")
            return skinned(vertices, joints, weights.astype(np.float64), self._joints(skin))
        transform = self._world[node]
        if np.array_equal(transform, np.eye(4)):
            return vertices, False
        placed = vertices @ transform[:3, :3].T + transform[:3, 3]
        return placed, bool(np.linalg.det(transform[:3, :3]) < 0)

    def _joints(self, skin: Any) -> Array:
        """(J, 4, 4)"""
        found = entry(self._document, "skins", skin)
        if skin not in self._skins:
            binds = found.get("inverseBindMatrices")
            matrices = None if binds is None else self._values(binds, (4, 4))
            self._skins[skin] = joint_matrices(found, self._world, matrices)
        return self._skins[skin]

    def _tint(self, primitive: dict[str, Any]) -> tuple[int, int, int] | None:
        """The one colour of its material."""
        if "material" not in primitive:
            return None
        material = entry(self._document, "materials", primitive["material"])
        glossy = material.get("extensions", {}).get(GLOSSY, {})
        factor = material.get("pbrMetallicRoughness", {}).get("baseColorFactor", glossy.get("diffuseFactor"))
        if factor is None:
            return None
        red, green, blue = (int(part) for part in srgb_bytes(np.array([factor], np.float64))[0])
        return red, green, blue

    def _unpacked(self, primitive: dict[str, Any]) -> dict[str, Any]:
        """The primitive with accessors of its own in place of those that Draco compressed."""
        key = id(primitive)
        if key not in self._unpacked_primitives:
            compressed = primitive["extensions"][DRACO]
            arrays, faces = draco_mesh(self._content(compressed["bufferView"]))
            accessors, attributes = self._document["accessors"], dict(primitive["attributes"])
            for name, number in compressed["attributes"].items():
                if name in attributes:
                    accessor = entry(self._document, "accessors", attributes[name])
                    values = np.asarray(arrays[number]).astype(DTYPES[accessor["componentType"]])
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
        return srgb_bytes(linear) if len(linear) == vertices else None

    def _painted(self, primitive: dict[str, Any], vertices: int) -> tuple[Array | None, bytes | None]:
        """((V, 2) texture coordinates from the lower left, the picture) where the primitive has both."""
        if not self._texture or "material" not in primitive:
            return None, None
        material = entry(self._document, "materials", primitive["material"])
        glossy = material.get("extensions", {}).get(GLOSSY, {})
        base = material.get("pbrMetallicRoughness", {}).get("baseColorTexture")
        painted = base or glossy.get("diffuseTexture") or material.get("emissiveTexture")
        if painted is None:
            return None, None
        placed = painted.get("extensions", {}).get("KHR_texture_transform", {})
        name = f"TEXCOORD_{whole(placed.get('texCoord', painted.get('texCoord', 0)), 'a texture coordinate')}"
        texture = entry(self._document, "textures", painted.get("index"))
        sources = [texture.get("extensions", {}).get(each, {}).get("source") for each in PICTURE_SOURCES]
        source = next((each for each in sources if each is not None), texture.get("source"))
        picture = None if source is None else self._picture(source)
        if source is None:
            self._notes.append(LEFT_OUT)
        if picture is None:
            return None, None
        if name not in primitive["attributes"]:
            self._notes.append(UNPLACED)
            return None, None
        uv = _transformed(self._values(primitive["attributes"][name], (2,)).astype(np.float64), placed)
        return (np.column_stack([uv[:, 0], 1.0 - uv[:, 1]]), picture) if len(uv) == vertices else (None, None)

    def _picture(self, index: Any) -> bytes | None:
        """The image as JPEG or PNG; what became of it is noted."""
        if index not in self._pictures:
            image = entry(self._document, "images", index)
            if "uri" in image and "content" not in image:
                self._pictures[index] = self._files.picture(str(image["uri"]))
                return self._pictures[index]
            content = image["content"] if "content" in image else self._content(image["bufferView"])
            self._pictures[index] = plain_picture(content)
            if self._pictures[index] is None:
                self._notes.append(LEFT_OUT)
            elif is_turned(content):
                self._notes.append(TURNED)
        return self._pictures[index]


def _transformed(uv: Array, placed: dict[str, Any]) -> Array:
    """(N, 2) coordinates, scaled, turned and moved as KHR_texture_transform says."""
    scale, offset = (
        np.array(placed.get(name, [each, each]), float) for name, each in (("scale", 1.0), ("offset", 0.0))
    )
    angle = float(placed.get("rotation", 0.0))
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return np.asarray((uv * scale.reshape(2)) @ turn.T + offset.reshape(2))


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
    if mode == TRIANGLE_FAN and len(corners) >= 3:
        return np.column_stack([np.full(len(corners) - 2, corners[0]), corners[1:-1], corners[2:]])
    return strip(corners)
