"""The example patient, standing, with lines of a pen on her skin: a zip of OBJ, MTL and texture; also a program.

    python inked_example.py EXAMPLES FOLDER

writes FOLDER/standing.zip of EXAMPLES/standing (see coarse_example.py).  The picture is painted from the front:
skin, and violet lines from the notch to the navel, along the left meridian, and around the left breast.
"""

import io
import json
import sys
import zipfile
from pathlib import Path

import numpy as np
import trimesh
from PIL import Image, ImageDraw

from breastrig.core.units import METRES_PER_UNIT

SIDE, OVER = 1024, 2  # pixels, and how many times finer it is painted
SKIN, VIOLET = (190, 145, 120), (74, 40, 112)
PEN = 2.2e-3  # m
MARGIN = 0.02  # of the picture


def inked_example(source: Path, target: Path) -> None:
    """Writes the zip; `source` holds scan.ply, in metres, and landmarks.json."""
    scan = trimesh.load(source / "scan.ply", process=False)
    document = json.loads((source / "landmarks.json").read_text())
    per_unit = METRES_PER_UNIT[document["unit"]]
    marks = {name: per_unit * np.asarray(place) for name, place in document["landmarks"].items()}
    left = marks["nipple_L"] - marks["nipple_R"]
    left /= np.linalg.norm(left)
    up = marks["suprasternal_notch"] - marks["umbilicus"]
    up -= (up @ left) * left
    up /= np.linalg.norm(up)
    axes = np.stack([left, up])
    flat = np.asarray(scan.vertices) @ axes.T
    low, reach = flat.min(axis=0), float(np.ptp(flat, axis=0).max())

    def shown(places: np.ndarray) -> np.ndarray:
        """(M, 2) uv of (M, 2) places seen from the front."""
        return MARGIN + (1 - 2 * MARGIN) * (places - low) / reach

    image = Image.new("RGB", (SIDE * OVER, SIDE * OVER), SKIN)
    pen = ImageDraw.Draw(image)
    width = round(PEN * (1 - 2 * MARGIN) / reach * SIDE * OVER)
    at = {name: axes @ place for name, place in marks.items()}
    turn = np.linspace(0, 2 * np.pi, 90)
    circle = at["nipple_L"] + 0.045 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    lines = [
        np.stack([at["suprasternal_notch"], at["umbilicus"]]),
        np.stack([at["midclavicle_L"], 0.3 * at["midclavicle_L"] + 0.7 * at["nipple_L"]]),
        circle,
    ]
    for line in lines:
        uv = shown(line)
        pen.line([(u * SIDE * OVER, (1 - v) * SIDE * OVER) for u, v in uv], fill=VIOLET, width=width, joint="curve")
    image = image.resize((SIDE, SIDE), Image.Resampling.BOX)
    noise = np.random.default_rng(1).normal(scale=2.0, size=(SIDE, SIDE, 1))
    picture = io.BytesIO()
    Image.fromarray(np.clip(np.asarray(image) + noise, 0, 255).astype(np.uint8)).save(picture, "JPEG", quality=90)
    front = np.cross(left, up)
    facing = np.asarray(scan.face_normals) @ front > 0.1
    uv = np.concatenate([shown(flat), [[0.005, 0.005]]])  # the last one is bare skin, for the back
    text = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in np.asarray(scan.vertices).tolist()]
    text += [f"vt {u:.6f} {v:.6f}" for u, v in uv.tolist()]
    text += ["mtllib scan.mtl", "usemtl skin"]
    for face, is_front in zip(np.asarray(scan.faces).tolist(), facing.tolist(), strict=True):
        text.append("f " + " ".join(f"{each + 1}/{(each if is_front else len(uv) - 1) + 1}" for each in face))
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("scan.obj", "\n".join(text) + "\n")
        archive.writestr("scan.mtl", "newmtl skin\nmap_Kd texture.jpg\n")
        archive.writestr("texture.jpg", picture.getvalue())


if __name__ == "__main__":
    inked_example(Path(sys.argv[1]) / "standing", Path(sys.argv[2]) / "standing.zip")
