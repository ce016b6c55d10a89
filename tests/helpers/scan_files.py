"""The toy rig's tube as scan files of every kind, made in memory."""

import io
import zipfile

import numpy as np
import trimesh
from PIL import Image

from helpers.toy_rig import toy_rig


def tube(scale: float = 1.0) -> trimesh.Trimesh:
    """204 vertices and 384 triangles, 0.6 m across times `scale`."""
    rig = toy_rig()
    return trimesh.Trimesh(rig.template * scale, rig.faces, process=False)


def as_bytes(mesh: trimesh.Trimesh, kind: str) -> bytes:
    """The mesh as ply, obj, stl, stl_ascii or glb."""
    exported = mesh.export(file_type=kind)
    return exported if isinstance(exported, bytes) else exported.encode()


def picture(kind: str = "JPEG", size: tuple[int, int] = (16, 8)) -> bytes:
    """A small red picture, with a comment that must not survive."""
    stream = io.BytesIO()
    Image.new("RGB", size, (200, 30, 30)).save(stream, kind, **({"comment": "Jane Doe"} if kind == "JPEG" else {}))
    return stream.getvalue()


def textured_obj(picture_name: str = "skin.jpg") -> dict[str, bytes]:
    """model.obj and model.mtl that name the picture."""
    mesh, uv = tube(), toy_rig().uv
    lines = ["mtllib model.mtl", "usemtl skin"]
    lines += ["v {:.6f} {:.6f} {:.6f}".format(*vertex) for vertex in mesh.vertices]
    lines += ["vt {:.6f} {:.6f}".format(*pair) for pair in uv]
    lines += ["f " + " ".join(f"{corner + 1}/{corner + 1}" for corner in face) for face in mesh.faces]
    material = f"newmtl skin\nKd 1 1 1\nmap_Kd {picture_name}\n"
    return {"model.obj": "\n".join(lines).encode(), "model.mtl": material.encode()}


def zipped(files: dict[str, bytes]) -> bytes:
    """A zip of these files."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return stream.getvalue()


def ply_text(vertices: np.ndarray, faces: np.ndarray) -> bytes:
    """An ASCII PLY, written without a library so that it can be wrong."""
    header = (
        f"ply\nformat ascii 1.0\nelement vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = [" ".join(map(str, vertex)) for vertex in vertices] + [
        " ".join(map(str, [len(face), *face])) for face in faces
    ]
    return (header + "\n".join(rows) + "\n").encode()
