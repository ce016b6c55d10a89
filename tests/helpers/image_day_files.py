"""What a person drops on the day of an image, of one body with a lesion in a breast: also a program.

    python image_day_files.py FOLDER

Writes image.zip (DICOM files of two series), lesion.dcm (a SEG of the lesion alone), standing.ply, supine.ply, and
truth.json: each stance's landmarks, and where the lesion is standing, mm.
"""

import json
import sys
from pathlib import Path

import numpy as np

from breastrig.geometry.caps import closed
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.scan.images.image import ImageVolume
from breastrig_studies.virtual.magnetic.image import Protocol, mr_image
from breastrig_studies.virtual.magnetic.woman import Woman, in_lps
from helpers.dicom_files import Series, files, uid, zipped
from helpers.label_maps import dicom_segmentation
from helpers.scan_files import ply_text

SEEN = ("suprasternal_notch", "mid_sternum", "xiphoid", "nipple_L", "nipple_R")  # in the image's field of view
FLATTER = np.array([1.0, 1.0, 0.95])  # supine


def image_day_files(folder: Path) -> None:
    """Writes them all."""
    folder.mkdir(parents=True, exist_ok=True)
    rig = read_rig(default_rig_path())
    marks = dict(zip(rig.landmark_names, rig.landmark_points().positions(rig.template, rig.faces), strict=True))
    shut = closed(rig.template, rig.faces)
    woman = Woman(in_lps(shut.vertices), shut.faces, {name: in_lps(place) for name, place in marks.items()})
    seen = mr_image(woman, Protocol(steps=(4.0, 4.0, 4.0)), seed=3)
    rough = ImageVolume(seen.image.values[::2, ::2, ::2], seen.image.affine @ np.diag([2.0, 2.0, 2.0, 1.0]))
    several = Series(seen.image, "t1 dynamic"), Series(rough, "survey", number=2)
    (folder / "image.zip").write_bytes(zipped(files(*several)))
    labels, low = np.where(seen.lesion, 2, 0), seen.image.affine[:3, 3]
    sizes = np.linalg.norm(seen.image.affine[:3, :3], axis=0)
    (folder / "lesion.dcm").write_bytes(dicom_segmentation(labels, low, sizes, uid("frame"), lesion_alone=True))
    for stance, turn in (("standing", np.ones(3)), ("supine", FLATTER)):
        (folder / f"{stance}.ply").write_bytes(ply_text(1e3 * rig.template * turn, rig.faces))
    frames = {"prone": in_lps, "standing": lambda at: 1e3 * at, "supine": lambda at: 1e3 * at * FLATTER}
    picks = {
        stance: {name: frame(marks[name]).tolist() for name in (*SEEN, *(() if stance == "prone" else ("umbilicus",)))}
        for stance, frame in frames.items()
    }
    x, y, z = seen.lesion_at
    (folder / "truth.json").write_text(json.dumps({"landmarks": picks, "lesion": [float(x), float(z), float(-y)]}))


if __name__ == "__main__":
    image_day_files(Path(sys.argv[1]))
