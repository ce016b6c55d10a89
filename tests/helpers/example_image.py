"""The example patient's MRI as a hospital gives it: the image as DICOM, and the lesions in another file."""

import zipfile
from functools import cache

import nibabel
import numpy as np

from breastrig.core.assets import asset_folder
from breastrig.scan.images.image import ImageVolume
from breastrig.scan.read import read_scan
from helpers.dicom_files import Series, files, lesion_seg, zipped

FOLDER = asset_folder("example") / "mri"
LESIONS = FOLDER / "scan.nii.gz"  # the label map of the same patient
LANDMARKS = FOLDER / "landmarks.json"


@cache
def example_image(*names: str, beside: bytes = b"") -> bytes:
    """A zip with a series of each name, of one where there is none, and a file of lesions beside them."""
    series = [Series(example_volume(), name) for name in names or ("t1",)]
    lesions = {"DICOM/SEG": beside} if beside else {}
    return zipped(files(*series) | lesions, zipfile.ZIP_DEFLATED)


@cache
def example_volume() -> ImageVolume:
    """Where the label map has a body, the image is light, in voxels of 5 mm; axial, its rows to the left."""
    labels = nibabel.load(LESIONS)
    labels = nibabel.as_closest_canonical(labels)
    shown = np.asarray(labels.dataobj)[::-1, ::-1] > 0
    affine = np.diag([-1.0, -1.0, 1.0, 1.0]) @ labels.affine
    affine[:3, 3] += affine[:3, :2] @ (np.array(shown.shape[:2]) - 1)
    affine[:3, :2] *= -1.0
    return ImageVolume((600 * shown[::2, ::2, ::2]).astype(np.uint16), affine @ np.diag([2.0, 2.0, 2.0, 1.0]))


@cache
def example_segmentation(frame_of: str = "frame") -> bytes:
    """DICOM SEG of one of its lesions alone, on the image's slices; another frame of reference by another name."""
    volume, lesion = example_volume(), read_scan(LESIONS).lesions[0]
    index = np.stack(np.meshgrid(*(np.arange(size) for size in volume.values.shape), indexing="ij"), axis=-1)
    away = np.linalg.norm(index @ volume.affine[:3, :3].T + volume.affine[:3, 3] - 1e3 * lesion.center, axis=-1)
    return lesion_seg(Series(volume, frame_of=frame_of), away < 1e3 * lesion.radius)
