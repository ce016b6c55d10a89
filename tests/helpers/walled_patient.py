"""A patient prone, with a lesion near a chest wall that a label map names, and standing: where the wall is still."""

import json
from functools import cache
from pathlib import Path

import numpy as np
from pydicom.dataset import Dataset

from breastrig.core.arrays import Array
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.scan.images.image import ImageVolume
from helpers.dicom_files import Series, files, uid, zipped
from helpers.grid_files import nrrd, nrrd_fields, slicer_words, to_lps
from helpers.label_maps import above_navel, in_lps, labels_behind
from helpers.scan_files import ply_text
from helpers.structure_sets import Region, ball, structures

WALL = 0.05  # m behind the tip of a breast that does not hang
LESION, RADIUS = 0.006, 6.0  # m over the wall, and mm
THICK, SIZE = 8.0, 3.0  # mm, of the wall and of a voxel
SEEN = ("suprasternal_notch", "mid_sternum", "xiphoid", "nipple_L", "nipple_R")
TISSUE = "SCT^85756007^Tissue"


def hanging(rig: Rig) -> Array:
    """(V, 3) m: the breasts' skin farther in front, as when they hang."""
    places, tips = rig.template, np.array([rig.template[rig.regions[f"areola_{side}"]].mean(axis=0) for side in "LR"])
    away = np.linalg.norm(places[:, None] - tips, axis=2).min(axis=1)
    return np.asarray(places + (0.04 * np.exp(-0.5 * (away / 0.025) ** 2))[:, None] * np.array([0.0, 0.2, 1.0]))


def marks(rig: Rig, vertices: Array, names: tuple[str, ...] = SEEN) -> dict[str, Array]:
    """(3,) m each."""
    return dict(zip(names, rig.landmark_points(names).positions(vertices, rig.faces), strict=True))


def lesion_of(rig: Rig) -> Array:
    """(3,) m, in both stances: near the wall, behind the left nipple."""
    return marks(rig, rig.template)["nipple_L"] - [0.0, 0.0, WALL - LESION]


@cache
def labels_of(rig: Rig) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Labels prone (2 the lesion, 3 the wall), (3,) mm LPS of the first voxel, and their sizes."""
    body, nipple = hanging(rig), marks(rig, rig.template)["nipple_L"]
    regions = ("breast_L", "breast_R", "areola_L", "areola_R", "chest", "belly")
    shown = np.unique(np.concatenate([rig.regions[name] for name in regions]))
    front = shown[rig.normals_at(rig.template)[shown, 2] > 0.2]
    labels, low = above_navel(*labels_behind(body[front], lesion_of(rig), RADIUS, SIZE), SIZE)
    behind = low[1] + SIZE * np.arange(labels.shape[1]) - in_lps(nipple)[1] - 1e3 * WALL
    plate = ((behind > 0.0) & (behind < THICK))[None, :, None]
    labels[plate & (labels == 1)] = 3
    return labels, low, np.full(3, SIZE)


def label_map(rig: Rig, wall: str = "Pectoral muscle") -> bytes:
    """As 3D Slicer writes it, the wall under that name."""
    labels, low, sizes = labels_of(rig)
    words = [("Body", 0, 1, TISSUE, TISSUE), ("Lesion", 0, 2, TISSUE, TISSUE), (wall, 0, 3, TISSUE, TISSUE)]
    return nrrd(labels, nrrd_fields(labels, to_lps(low, sizes)), slicer_words(words))


def contours(rig: Rig, wall: str = "Chest wall", lesion: str = "GTV") -> bytes:
    """RTSTRUCT of the wall and the lesion under these names, in the frame of `image`; without one that has no name."""
    labels, low, sizes = labels_of(rig)
    front = in_lps(marks(rig, rig.template)["nipple_L"])[1] + 1e3 * WALL
    across, _, along = (low[k] + sizes[k] * np.unique(at) for k, at in enumerate(np.nonzero(labels == 3)))
    sides = [(across[0], front), (across[-1], front), (across[-1], front + THICK), (across[0], front + THICK)]
    plate = Region([np.array([[x, y, z] for x, y in sides]) for z in along], wall)
    shift = np.array([0.0, 0.0, along[0] % sizes[2]])  # to the planes of the plate
    inside = ball(in_lps(lesion_of(rig)) - shift, RADIUS, float(sizes[2]))
    regions = [plate, Region([each + shift for each in inside.contours], lesion)]
    return structures([each for each in regions if each.name], uid("frame"))


@cache
def image(rig: Rig, beside: bytes = b"", position: str = "") -> bytes:
    """The MRI of these labels as DICOM in a zip: light where there is a body; with a file of lesions beside it.

    `position` is what each header has as PatientPosition.
    """

    def lying(made: Dataset, _at: int) -> None:
        if position:
            made.PatientPosition = position

    labels, low, sizes = labels_of(rig)
    series = Series(ImageVolume((600 * (labels > 0)).astype(np.uint16), to_lps(low, sizes)), change=lying)
    return zipped(files(series) | ({"RTSTRUCT": beside} if beside else {}))


def walled_patient(folder: Path) -> Rig:
    """Writes mri.nrrd, standing.ply (mm) and the landmarks of both (prone.json, standing.json)."""
    rig = read_rig(default_rig_path())
    (folder / "mri.nrrd").write_bytes(label_map(rig))
    (folder / "standing.ply").write_bytes(ply_text(1e3 * rig.template, rig.faces))
    prone = {name: in_lps(place).tolist() for name, place in marks(rig, hanging(rig)).items()}
    standing = {name: (1e3 * place).tolist() for name, place in marks(rig, rig.template).items()}
    for stance, places in (("prone", prone), ("standing", standing)):
        (folder / f"{stance}.json").write_text(json.dumps({"unit": "mm", "landmarks": places}))
    return rig
