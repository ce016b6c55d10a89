"""The example patient's MRI as a hospital gives it: the image as DICOM, and the lesions in another file."""

import zipfile
from functools import cache

import nibabel
import numpy as np

from breastrig.core.assets import asset_folder
from breastrig.scan.images.image import ImageVolume
from helpers.dicom_files import Series, files, zipped

FOLDER = asset_folder("example") / "mri"
LESIONS = FOLDER / "scan.nii.gz"  # the label map of the same patient
LANDMARKS = FOLDER / "landmarks.json"


@cache
def example_image() -> bytes:
    """A zip of one series."""
    return zipped(files(Series(example_volume())), zipfile.ZIP_DEFLATED)


def example_volume() -> ImageVolume:
    """Where the label map has a body, the image is light."""
    labels = nibabel.load(LESIONS)
    shown = np.asarray(labels.dataobj) > 0
    return ImageVolume((600 * shown).astype(np.uint16), np.diag([-1.0, -1.0, 1.0, 1.0]) @ labels.affine)
