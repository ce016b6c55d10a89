"""What a person uploads on the lesion's day, of one body with a lesion in the left breast: also a program.

    python lesion_day_files.py FOLDER

Writes mri.nii.gz, balls.nii.gz (`label_maps.body_labels`), no_side.nii.gz (its header does not say which side is left),
seg.zip (a DICOM SEG), broken.nii.gz, standing.ply, each stance's landmarks (prone.json, standing.json), and
lesion.json: where it is standing, mm.
"""

import gzip
import json
import sys
import zipfile
from pathlib import Path

import numpy as np

from breastrig.gltf.read_rig import default_rig_path, read_rig
from helpers.label_maps import (
    above_navel,
    body_labels,
    dicom_segmentation,
    front_labels,
    in_lps,
    nifti,
    placed_nifti,
)
from helpers.scan_files import ply_text

SEEN = ("suprasternal_notch", "mid_sternum", "xiphoid", "nipple_L", "nipple_R")  # in an MRI's field of view
RADIUS = 7.0  # mm


def lesion_day_files(folder: Path) -> None:
    """Writes them all."""
    folder.mkdir(parents=True, exist_ok=True)
    rig = read_rig(default_rig_path())
    marks = dict(zip(rig.landmark_names, rig.landmark_points().positions(rig.template, rig.faces), strict=True))
    inside = marks["nipple_L"] - [0.012, 0.0, 0.028]
    whole, start, size = front_labels(rig, inside, RADIUS)
    labels, low = above_navel(whole, start, size)
    labels, sizes = np.ascontiguousarray(labels[::2, ::2, ::2]), np.full(3, 2 * size)
    mri = gzip.compress(nifti(labels, low=low, sizes=sizes))
    unsaid = np.diag([*sizes, 1.0]), 0
    (folder / "mri.nii.gz").write_bytes(mri)
    (folder / "balls.nii.gz").write_bytes(gzip.compress(nifti(body_labels())))
    (folder / "no_side.nii.gz").write_bytes(gzip.compress(placed_nifti(labels, unsaid, unsaid)))
    (folder / "broken.nii.gz").write_bytes(mri[: len(mri) // 2])
    with zipfile.ZipFile(folder / "seg.zip", "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("DICOM/IM000001", dicom_segmentation(labels, low, sizes))
    (folder / "standing.ply").write_bytes(ply_text(1e3 * rig.template, rig.faces))
    frames = {"prone": (SEEN, in_lps), "standing": ((*SEEN, "umbilicus"), lambda point: 1e3 * point)}
    for stance, (names, frame) in frames.items():
        places = {name: frame(marks[name]).tolist() for name in names}
        (folder / f"{stance}.json").write_text(json.dumps({"unit": "mm", "landmarks": places}))
    (folder / "lesion.json").write_text(json.dumps((1e3 * inside).tolist()))


if __name__ == "__main__":
    lesion_day_files(Path(sys.argv[1]))
