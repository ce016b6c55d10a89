"""Scan files of every kind that say a patient's name wherever their format has a place for words."""

import io
import json
import zipfile

import numpy as np
import trimesh
from PIL import Image, PngImagePlugin

from breastrig.core.glb import pack_glb, split_glb
from breastrig.gltf.mesh_glb import mesh_glb
from helpers.scan_files import as_bytes, textured_obj, tube
from helpers.toy_rig import toy_rig

NAME = "Mustermann"
WORDS = f"Erika {NAME} 1970"


def body(colours: bool = False) -> trimesh.Trimesh:
    mesh = tube()
    if colours:
        random = np.random.default_rng(5).integers(0, 256, (len(mesh.vertices), 4)).astype(np.uint8)
        mesh.visual = trimesh.visual.ColorVisuals(mesh, vertex_colors=random)
    return mesh


def named_picture(kind: str, size: tuple[int, int] = (40, 24)) -> bytes:
    """A noisy picture with a comment, EXIF with a place, a profile, a preview and bytes after its end."""
    random = np.random.default_rng(6).integers(0, 256, (size[1], size[0], 3)).astype(np.uint8)
    image = Image.fromarray(random)
    exif = Image.Exif()
    exif[0x010E], exif[0x013B], exif[0x0112] = WORDS, WORDS, 6  # description, artist, turned by a quarter
    exif.get_ifd(0x8825)[1] = "N"  # GPS
    more: dict[str, object] = {"icc_profile": WORDS.encode(), "exif": exif}
    if kind == "PNG":
        text = PngImagePlugin.PngInfo()
        text.add_text("Author", WORDS)
        text.add_itxt("XML:com.adobe.xmp", WORDS)
        more["pnginfo"] = text
    else:
        more |= {"comment": WORDS, "xmp": WORDS.encode(), "progressive": True}
    stream = io.BytesIO()
    image.save(stream, kind, **more)
    return stream.getvalue() + WORDS.encode()


def named_ply(text: bool = False) -> bytes:
    data = body(colours=True).export(file_type="ply", encoding="ascii" if text else "binary")
    words = f"comment {WORDS}\nobj_info {WORDS}\ncomment Praxis Dr. Müller\n".encode("latin-1")
    return data.replace(b"element vertex", words + b"element vertex", 1)


def named_obj() -> bytes:
    return f"# {WORDS}\nmtllib {NAME}.mtl\no {NAME}\ng {NAME}\nusemtl {NAME}\n".encode() + as_bytes(body(), "obj")


def named_stl(text: bool = False) -> bytes:
    if text:
        return as_bytes(body(), "stl_ascii").replace(b"solid", b"solid " + WORDS.encode())
    return WORDS.encode().ljust(80) + as_bytes(body(), "stl")[80:]


def named_glb() -> bytes:
    mesh = body()
    uv = np.random.default_rng(7).uniform(0.0, 1.0, (len(mesh.vertices), 2))
    document, binary = split_glb(mesh_glb(mesh.vertices, mesh.faces, uv=uv, texture=named_picture("JPEG")))
    document["asset"] |= {"copyright": WORDS, "extras": {"patient": WORDS}}
    for kind in ("nodes", "meshes", "materials", "images", "accessors", "scenes"):
        for item in document[kind]:
            item |= {"name": WORDS, "extras": {"patient": WORDS}}
    return pack_glb(json.dumps(document).encode(), binary + WORDS.encode())


def named_zip(kind: str = "JPEG") -> bytes:
    picture = f"{NAME}.{'jpg' if kind == 'JPEG' else 'png'}"
    files = textured_obj(picture)
    vertices, uv = toy_rig().template, toy_rig().uv
    corners = [f"f {' '.join(f'{corner + 1}/{corner + 1}' for corner in face)}" for face in toy_rig().faces]
    lines = [f"# {WORDS}", f"mtllib {NAME}.mtl", f"o {NAME}", f"usemtl {NAME}"]
    lines += ["v {} {} {}".format(*vertex) for vertex in vertices] + ["vt {} {}".format(*pair) for pair in uv]
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.comment = WORDS.encode()
        archive.writestr(f"{NAME}.obj", "\n".join([*lines, *corners, ""]))
        archive.writestr(f"{NAME}.mtl", files["model.mtl"].replace(b"newmtl skin", f"newmtl {NAME}".encode()))
        archive.writestr(picture, named_picture(kind))
        archive.writestr(f"{NAME}_room.jpg", named_picture("JPEG", (64, 64)))
        archive.writestr(f"__MACOSX/._{NAME}", WORDS)
    return stream.getvalue()


NAMED = {
    "ply": named_ply,
    "text.ply": lambda: named_ply(text=True),
    "obj": named_obj,
    "stl": named_stl,
    "text.stl": lambda: named_stl(text=True),
    "glb": named_glb,
    "zip": named_zip,
    "png.zip": lambda: named_zip("PNG"),
}
