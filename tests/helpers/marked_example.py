"""The example's scans with colours: plain skin with moles and dots of a pen at the same places of both."""

import hashlib
import io
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

import breastrig
from breastrig.core.assets import asset_folder
from breastrig.files.result import RESULT, read_result
from breastrig.geometry.normals import face_normals
from breastrig.use.folder.fit_folder import read_fit_files

SIDE, WIDTH = 1280, 0.8  # pixels, m
SKIN, MOLE, DOT = (205, 160, 140), (95, 60, 45), (50, 40, 130)
PLACES = {  # m to the left, up and in front of a landmark of the template
    "nipple_L": (0.03, 0.04, 0.0),
    "nipple_R": (-0.03, 0.04, 0.0),
    "xiphoid": (0.01, -0.03, 0.0),
    "mid_sternum": (0.0, 0.0, 0.0),
}


@dataclass(frozen=True)
class MarkedScan:
    """A coloured scan of the example, and the places of its marks in its unit and frame."""

    content: bytes  # a zip of OBJ, MTL and PNG
    places: np.ndarray  # (4, 3)


def marked_example(fit: breastrig.Fit, stance: str) -> MarkedScan:
    """The scan of a fit of the example, with marks where the fitted model has some of its vertices."""
    scan = breastrig.read_scan(asset_folder("example") / stance / "scan.ply")
    metres, frame = scan.metres_per_unit, fit.frame
    axes = np.stack([frame.left, frame.up, frame.front])
    middle = scan.vertices.mean(axis=0)
    seen = metres * (scan.vertices - middle) @ axes.T
    rig, template = fit.model, fit.model.template
    beside = rig.landmark_points(tuple(PLACES)).positions(template, rig.faces) + np.array([*PLACES.values()])
    vertices = [int(np.linalg.norm(template - place, axis=1).argmin()) for place in beside]
    places = np.array(
        [scan.vertices[np.linalg.norm(scan.vertices - fit.vertices[v], axis=1).argmin()] for v in vertices]
    )
    pixels = np.full((SIDE, SIDE, 3), SKIN, dtype=np.uint8)
    row, column = np.mgrid[:SIDE, :SIDE]
    for number, (x, y, _) in enumerate(metres * (places - middle) @ axes.T):
        near = np.hypot(column - SIDE * (x / WIDTH + 0.5), row - SIDE * (0.5 - y / WIDTH)) * WIDTH / SIDE < 2e-3
        pixels[near] = DOT if number % 2 else MOLE
    front = face_normals(seen, scan.faces)[:, 2] > 0.0
    lines = ["mtllib scan.mtl", "usemtl skin", *(f"v {x!r} {y!r} {z!r}" for x, y, z in scan.vertices.tolist())]
    lines += [f"vt {x / WIDTH + 0.5:.6f} {y / WIDTH + 0.5:.6f}" for x, y, _ in seen]
    lines.append("vt 0.001 0.001")
    corners = np.where(front[:, None], scan.faces, len(seen)) + 1
    lines += [
        "f " + " ".join(f"{v}/{t}" for v, t in zip(face, own, strict=True))
        for face, own in zip((scan.faces + 1).tolist(), corners.tolist(), strict=True)
    ]
    picture, packed = io.BytesIO(), io.BytesIO()
    Image.fromarray(pixels).save(picture, "PNG")
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("scan.obj", "\n".join(lines) + "\n")
        archive.writestr("scan.mtl", "newmtl skin\nmap_Kd texture.png\n")
        archive.writestr("texture.png", picture.getvalue())
    return MarkedScan(packed.getvalue(), places)


def of_scan(folder: Path, content: bytes) -> None:
    """Says in a fit's folder that it was made of another scan."""
    result = read_result(folder)
    scan = result.scan.model_copy(update={"sha256": hashlib.sha256(content).hexdigest()})
    signed = result.model_copy(update={"scan": scan}).beside(read_fit_files(folder))
    (folder / RESULT).write_bytes(signed.content())
