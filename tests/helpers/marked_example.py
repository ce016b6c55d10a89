"""Coloured scans: plain skin with moles and dots of a pen at the same places of both stances.

As a program: FOLDER/{standing,supine}.zip of the template, in metres, and truth.json with its landmarks in mm.
"""

import hashlib
import io
import json
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

import breastrig
from breastrig.core.assets import asset_folder
from breastrig.files.result import RESULT, read_result
from breastrig.geometry.normals import face_normals
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.use.folder.fit_folder import read_fit_files

SIDE, WIDTH = 1280, 0.8  # pixels, m
SKIN, MOLE, DOT = (205, 160, 140), (95, 60, 45), (50, 40, 130)
PLACES = {  # m to the left, up and in front of a landmark of the template
    "nipple_L": (0.03, 0.04, 0.0),
    "nipple_R": (-0.03, 0.04, 0.0),
    "xiphoid": (0.01, -0.03, 0.0),
    "mid_sternum": (0.0, 0.0, 0.0),
}
FLATTER = np.array([1.0, 1.0, 0.95])  # supine


@dataclass(frozen=True)
class MarkedScan:
    """A coloured scan of the example, and the places of its marks in its unit and frame."""

    content: bytes  # a zip of OBJ, MTL and PNG
    places: np.ndarray  # (4, 3)


def marked_example(fit: breastrig.Fit, stance: str) -> MarkedScan:
    """The scan of a fit of the example, with marks where the fitted model has some of its vertices."""
    scan = breastrig.read_scan(asset_folder("example") / stance / "scan.ply")
    middle, axes = scan.vertices.mean(axis=0), np.stack([fit.frame.left, fit.frame.up, fit.frame.front])
    fitted = fit.vertices[marked_vertices(fit.model)]
    places = np.array([scan.vertices[np.linalg.norm(scan.vertices - place, axis=1).argmin()] for place in fitted])
    seen, at = (scan.metres_per_unit * (each - middle) @ axes.T for each in (scan.vertices, places))
    return MarkedScan(marked_zip(scan.vertices, scan.faces, seen, at), places)


def marked_vertices(rig: Rig) -> list[int]:
    """Four vertices of the template."""
    beside = rig.landmark_points(tuple(PLACES)).positions(rig.template, rig.faces) + np.array([*PLACES.values()])
    return [int(np.linalg.norm(rig.template - place, axis=1).argmin()) for place in beside]


def marked_zip(vertices: np.ndarray, faces: np.ndarray, seen: np.ndarray, places: np.ndarray) -> bytes:
    """A zip of OBJ, MTL and PNG of (V, 3) vertices, with marks at (M, 3); the picture is taken from the front.

    `seen` (V, 3) and `places` are m to the left, up and to the front of the middle.
    """
    pixels = np.full((SIDE, SIDE, 3), SKIN, dtype=np.uint8)
    row, column = np.mgrid[:SIDE, :SIDE]
    for number, (x, y, _) in enumerate(places):
        near = np.hypot(column - SIDE * (x / WIDTH + 0.5), row - SIDE * (0.5 - y / WIDTH)) * WIDTH / SIDE < 2e-3
        pixels[near] = DOT if number % 2 else MOLE
    front = face_normals(seen, faces)[:, 2] > 0.0
    lines = ["mtllib scan.mtl", "usemtl skin", *(f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist())]
    lines += [f"vt {x / WIDTH + 0.5:.6f} {y / WIDTH + 0.5:.6f}" for x, y, _ in seen]
    lines.append("vt 0.001 0.001")  # of all that looks to the back
    corners = np.where(front[:, None], faces, len(seen)) + 1
    lines += [
        "f " + " ".join(f"{v}/{t}" for v, t in zip(face, own, strict=True))
        for face, own in zip((faces + 1).tolist(), corners.tolist(), strict=True)
    ]
    picture, packed = io.BytesIO(), io.BytesIO()
    Image.fromarray(pixels).save(picture, "PNG")
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("scan.obj", "\n".join(lines) + "\n")
        archive.writestr("scan.mtl", "newmtl skin\nmap_Kd texture.png\n")
        archive.writestr("texture.png", picture.getvalue())
    return packed.getvalue()


def of_scan(folder: Path, content: bytes) -> None:
    """Says in a fit's folder that it was made of another scan."""
    result = read_result(folder)
    scan = result.scan.model_copy(update={"sha256": hashlib.sha256(content).hexdigest()})
    signed = result.model_copy(update={"scan": scan}).beside(read_fit_files(folder))
    (folder / RESULT).write_bytes(signed.content())


def marked_template_files(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    rig, truth = read_rig(default_rig_path()), {}
    for stance, turn in (("standing", np.ones(3)), ("supine", FLATTER)):
        vertices = rig.template * turn
        seen = vertices - vertices.mean(axis=0)
        (folder / f"{stance}.zip").write_bytes(marked_zip(vertices, rig.faces, seen, seen[marked_vertices(rig)]))
        points = rig.landmark_points().positions(vertices, rig.faces)
        truth[stance] = dict(zip(rig.landmark_names, (1e3 * points).tolist(), strict=True))
    (folder / "truth.json").write_text(json.dumps(truth))


if __name__ == "__main__":
    marked_template_files(Path(sys.argv[1]))
