"""A volume's file of any kind -> its segments where it is a label map, its numbers where it is an image."""

import importlib.util
from collections.abc import Callable

from breastrig.core.errors import BadScan, BadSettings
from breastrig.scan.volumes.dicom_seg import dataset_of, segmentation_volume
from breastrig.scan.volumes.dicom_structures import is_structures, structures_volume
from breastrig.scan.volumes.grids.grid import Grid, volume_of
from breastrig.scan.volumes.grids.meta_image import read_meta_image
from breastrig.scan.volumes.grids.nifti import read_nifti
from breastrig.scan.volumes.grids.nrrd import read_nrrd
from breastrig.scan.volumes.unlogged import unlogged
from breastrig.scan.volumes.volume import Volume

NEEDS = 'Label maps and MRI need "breastrig[mri]"; install it, or export the skin as PLY, STL or OBJ.'
SAYS_ITSELF = "A DICOM segmentation says itself where it lies; leave frame out."
GRIDS: dict[str, Callable[[bytes, str | None], Grid]] = {
    "nifti": read_nifti,
    "nrrd": read_nrrd,
    "mha": read_meta_image,
}


def read_volume(data: bytes, kind: str, frame: str | None, with_contours: bool = False) -> Volume | Grid:
    """`kind` is one of GRIDS, or dicom (of segmentations); `frame` is a person's answer.

    `with_contours` reads structure sets, too: their contours are closed where the image ends, so they show no skin.

    Raises BadScan or TooLarge with a sentence, BadSettings for an answer that does not fit this file.
    """
    if importlib.util.find_spec("pydicom" if kind == "dicom" else "nibabel") is None:
        raise BadScan(NEEDS)
    with unlogged():
        if kind in GRIDS:
            grid = GRIDS[kind](data, frame)
            return volume_of(grid) or grid
        if frame is not None:
            raise BadSettings(SAYS_ITSELF)
        dataset = dataset_of(data)
        return structures_volume(dataset) if with_contours and is_structures(dataset) else segmentation_volume(dataset)
