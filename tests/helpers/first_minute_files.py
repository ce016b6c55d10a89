"""What is dropped at once in the first minute, of one virtual woman: also a program.

    python first_minute_files.py FOLDER

Writes standing.ply, supine.ply and mri.nii.gz (a label map of the same body, with a lesion in the left breast), and
truth.json: by stance its skin (the same vertices in both) and landmarks, standing the lesion as well, mm in the frame
of that stance's file.
"""

import gzip
import json
import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.units import METRES_PER_UNIT
from breastrig.geometry.normals import vertex_normals
from breastrig_studies.virtual.bodies import read_bodies
from breastrig_studies.virtual.case_files import moved
from breastrig_studies.virtual.make import make_cohort
from helpers.label_maps import labels_behind, nifti

WOMAN = "patient_7"
RADIUS = 7.0  # mm


def first_minute_files(folder: Path) -> None:
    """Writes them all."""
    make_cohort(folder, lambda _: None, [WOMAN])
    bodies = read_bodies()
    (woman,) = (each for each in bodies.patients if each.name == WOMAN)
    (standing,) = (body for body in woman.bodies if body.stance == "standing")
    vertices, marks = standing.vertices, standing.landmarks
    lesion = marks["nipple_L"] - [0.012, 0.0, 0.028]
    low = min(marks[f"inframammary_fold_{side}"][1] for side in "LR") - 0.05
    wide = marks["acromion_L"][0] - 0.02
    seen = (np.abs(vertices[:, 0]) < wide) & (vertices[:, 1] > low) & (vertices[:, 1] < marks["midclavicle_L"][1])
    front = vertices[seen & (vertex_normals(vertices, bodies.faces)[:, 2] > 0.2)]
    labels, corner, size = labels_behind(front, lesion, RADIUS)
    (folder / "mri.nii.gz").write_bytes(gzip.compress(nifti(labels, low=corner, sizes=np.full(3, size))))
    truth: dict[str, Any] = {}
    for body in woman.bodies:
        place = folder / WOMAN / body.stance
        case = json.loads((place / "case.json").read_text("utf-8"))
        to_scan = (
            METRES_PER_UNIT[case["unit"]] * 1e3 * np.array(case["body_mm_to_scan"])[:3] @ np.diag([1e3, 1e3, 1e3, 1])
        )
        shutil.copy(place / "scan.ply", folder / f"{body.stance}.ply")
        truth[body.stance] = {
            "skin": np.round(moved(body.vertices, to_scan), 2).tolist(),
            "landmarks": {name: moved(at, to_scan).tolist() for name, at in body.landmarks.items()},
        } | ({"lesion": moved(lesion, to_scan).tolist()} if body is standing else {})
    (folder / "truth.json").write_text(json.dumps(truth))


if __name__ == "__main__":
    first_minute_files(Path(sys.argv[1]))
