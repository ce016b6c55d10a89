"""One small coloured body as programs write it: each variant's file, or its zip, made in memory.

The toy rig's tube; its colour is linear in its place in the picture, so vertices, faces and pictures all agree.
"""

import base64
import io
import json
import struct

import numpy as np
from PIL import Image

from breastrig.core.glb import pack_glb
from helpers.scan_files import zipped
from helpers.toy_rig import toy_rig

RIG = toy_rig()
VERTICES, FACES, UV = RIG.template.astype(np.float32).astype(np.float64), RIG.faces, RIG.uv
SIZES = {"float": "f4", "double": "f8", "uchar": "u1", "int": "i4", "uint": "u4", "short": "i2", "ushort": "u2"}


def colour(uv: np.ndarray) -> np.ndarray:
    """(..., 3) from 0 to 255 at these places of the picture, from its lower left."""
    u, v = uv[..., 0], uv[..., 1]
    return np.stack([20.0 + 210.0 * u, 30.0 + 200.0 * v, 120.0 - 60.0 * u], axis=-1)


OF_VERTICES = np.round(colour(UV)).astype(np.uint8)
OF_FACES = np.round(colour(UV[FACES].mean(axis=1))).astype(np.uint8)


def pixels(side: int = 128) -> np.ndarray:
    middle = (np.arange(side) + 0.5) / side
    u, v = np.meshgrid(middle, 1.0 - middle)
    return np.round(colour(np.stack([u, v], axis=-1))).astype(np.uint8)


def saved(kind: str, image: Image.Image | None = None, **options: object) -> bytes:
    stream = io.BytesIO()
    (image or Image.fromarray(pixels())).save(stream, kind, **options)
    return stream.getvalue()


JPEG = saved("JPEG", quality=95, subsampling=0)


def obj(
    head: str = "mtllib scan.mtl", uv: bool = True, colours: np.ndarray | None = None, corner: str | None = None
) -> bytes:
    """With a place in the picture for each vertex, or colours behind the places (rows may be shorter)."""
    more = ["" for _ in VERTICES] if colours is None else [" " + " ".join(f"{n:.6g}" for n in row) for row in colours]
    lines = [head, *(f"v {x:.6f} {y:.6f} {z:.6f}{rest}" for (x, y, z), rest in zip(VERTICES, more, strict=True))]
    lines += [f"vt {u:.6f} {v:.6f}" for u, v in UV] if uv else []
    lines.append("usemtl skin")
    corner = corner or ("{0}/{0}" if uv else "{0}")
    count = len(VERTICES)
    lines += ["f " + " ".join(corner.format(k + 1, k - count) for k in face) for face in FACES]
    return ("\n".join(lines) + "\n").encode()


def painted_obj(material: str, files: dict[str, bytes], name: str = "scan.mtl", head: str | None = None) -> bytes:
    """A zip of an OBJ with this material file and these files beside it."""
    mesh = obj(head or f"mtllib {name}")
    return zipped({"scan.obj": mesh, name: material.encode(), **files})


def ply(
    vertex: dict[str, tuple[str, np.ndarray]] | None = None,
    face: dict[str, tuple[str, np.ndarray]] | None = None,
    form: str = "binary_little_endian",
    polygons: list[list[int]] | None = None,
    corners: str = "list uchar int vertex_indices",
    head: str = "",
    before: bool = False,
) -> bytes:
    """Any PLY: further properties of vertices and faces (kind, values; `list uchar float` with rows), text or binary.

    `before`: the face's further properties stand before its corners.
    """
    columns = {axis: ("float", VERTICES[:, k]) for k, axis in enumerate("xyz")} | (vertex or {})
    polygons = polygons or FACES.tolist()
    own = {corners.split()[-1]: (corners.rsplit(" ", 1)[0], polygons)}
    rows = (face or {}) | own if before else own | (face or {})
    lines = ["ply", f"format {form} 1.0", *([head] if head else []), f"element vertex {len(VERTICES)}"]
    lines += [f"property {kind} {name}" for name, (kind, _) in columns.items()]
    lines += [f"element face {len(polygons)}", *(f"property {kind} {name}" for name, (kind, _) in rows.items())]
    order = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}[form]

    def cell(kind: str, value: object) -> bytes:
        words = kind.split()
        values = list(value) if words[0] == "list" else [value]
        if not order:
            shown = [str(len(values))] if words[0] == "list" else []
            return " ".join([*shown, *(f"{each:.9g}" for each in values)]).encode() + b" "
        length = np.array(len(values), order + SIZES[words[1]]).tobytes() if words[0] == "list" else b""
        return length + np.array(values, order + SIZES[words[-1]]).tobytes()

    def table(of: dict[str, tuple[str, np.ndarray]], count: int) -> bytes:
        end = b"" if order else b"\n"
        return b"".join(b"".join(cell(kind, values[row]) for kind, values in of.values()) + end for row in range(count))

    text = ("\n".join([*lines, "end_header"]) + "\n").encode()
    return text + table(columns, len(VERTICES)) + table(rows, len(polygons))


def vertex_colours(kind: str, values: np.ndarray, names: str = "red green blue") -> dict[str, tuple[str, np.ndarray]]:
    return {name: (kind, values[:, k]) for k, name in enumerate(names.split())}


def quads() -> list[list[int]]:
    """The tube's triangles two by two as quads, some left as triangles."""
    found: list[list[int]] = []
    waiting = FACES.tolist()
    while waiting:
        one = waiting.pop(0)
        other = waiting[0] if waiting else one
        shared = [k for k in one if k in other]
        if len(shared) == 2 and len(found) % 5:
            (far,) = (k for k in other if k not in one)
            at = next(k for k in range(3) if one[k] not in shared)
            found.append([one[(at + 1) % 3], far, one[(at + 2) % 3], one[at]])
            waiting.pop(0)
        else:
            found.append(one)
    return found


def stl(
    attributes: np.ndarray | None = None, title: bytes = b"scan", count: int | None = None, more: bytes = b""
) -> bytes:
    rows = np.zeros(len(FACES), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    rows["corners"] = VERTICES[FACES]
    if attributes is not None:
        rows["attribute"] = attributes
    return title.ljust(80) + struct.pack("<I", len(FACES) if count is None else count) + rows.tobytes() + more


def stl_text(word: str = "{}", number: str = "{:.6f}") -> bytes:
    """With its words in another form."""
    lines = [word.format("solid scan")]
    for face in FACES:
        lines += [word.format("facet normal 0 0 0"), word.format("outer loop")]
        lines += [word.format("vertex ") + " ".join(number.format(n) for n in VERTICES[k]) for k in face]
        lines += [word.format("endloop"), word.format("endfacet")]
    return ("\n".join([*lines, word.format("endsolid scan")]) + "\n").encode()


def gltf(
    attributes: dict[str, np.ndarray] | None = None,
    material: dict[str, object] | None = None,
    image: tuple[bytes, str] | None = None,
    texture: dict[str, object] | None = None,
    position: np.ndarray | None = None,
    node: dict[str, object] | None = None,
    extensions: tuple[str, ...] = (),
    required: bool = False,
    normalised: tuple[str, ...] = (),
) -> tuple[dict[str, object], bytes]:
    """(document, its one buffer): one primitive, or as many as are in `material`'s list."""
    arrays = {"POSITION": VERTICES.astype("f4") if position is None else position} | (attributes or {})
    kinds = {"f4": 5126, "i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125}
    binary, views, accessors = b"", [], []

    def add(values: np.ndarray, kind: str, is_normalised: bool = False) -> int:
        nonlocal binary
        row = values.reshape(len(values), -1)
        size = row.shape[1] * row.itemsize
        stride = -(-size // 4) * 4 if kind != "SCALAR" else size
        content = row if stride == size else np.pad(row, ((0, 0), (0, (stride - size) // row.itemsize)))
        view = {"buffer": 0, "byteOffset": len(binary), "byteLength": content.nbytes}
        views.append(view | ({"byteStride": stride} if kind != "SCALAR" else {}))
        binary += content.tobytes() + bytes(-content.nbytes % 4)
        component = kinds[values.dtype.str[1:]]
        found = {"bufferView": len(views) - 1, "componentType": component, "count": len(values), "type": kind}
        accessors.append(found | ({"normalized": True} if is_normalised else {}))
        return len(accessors) - 1

    named = {name: add(values, f"VEC{values.shape[1]}", name in normalised) for name, values in arrays.items()}
    primitive: dict[str, object] = {"attributes": named, "indices": add(FACES.astype("u4").ravel(), "SCALAR")}
    document: dict[str, object] = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, **(node or {})}],
        "accessors": accessors,
        "bufferViews": views,
        "extensionsUsed": list(extensions),
        **({"extensionsRequired": list(extensions)} if required else {}),
    }
    if material is not None:
        document["materials"] = [material]
        primitive["material"] = 0
    if image is not None:
        content, mime = image
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(content)})
        binary += content + bytes(-len(content) % 4)
        document["images"] = [{"bufferView": len(views) - 1, "mimeType": mime}]
        document["textures"] = [{"source": 0} if texture is None else texture]
    document["meshes"] = [{"primitives": [primitive]}]
    document["buffers"] = [{"byteLength": len(binary)}]
    return document, binary


def glb(*args: object, **options: object) -> bytes:
    document, binary = gltf(*args, **options)
    return pack_glb(json.dumps(document).encode(), binary)


def embedded(document: dict[str, object], binary: bytes) -> bytes:
    """A .gltf with its buffer inside."""
    inside = "data:application/octet-stream;base64," + base64.b64encode(binary).decode()
    return json.dumps({**document, "buffers": [{"byteLength": len(binary), "uri": inside}]}).encode()


UV_FLIPPED = np.column_stack([UV[:, 0], 1.0 - UV[:, 1]]).astype("f4")  # as glTF counts
BASE = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}


def linear(srgb: np.ndarray) -> np.ndarray:
    share = srgb / 255.0
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
