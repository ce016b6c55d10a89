"""An image as it is kept with its scan and shown: grey values of one byte, few enough to be sent to a page."""

import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array, frozen
from breastrig.core.errors import BadScan

KEPT_BYTES = 12 * 2**20  # of the voxels
DAMAGED = "The stored image is damaged; upload the scan again."


@dataclass(frozen=True, eq=False)
class KeptImage:
    """An image as it is kept with its scan and shown: at most KEPT_BYTES."""

    values: NDArray[np.uint8]  # (I, J, K)
    affine: Array  # (4, 4) indices of a voxel's middle to mm, LPS
    frame: str = ""  # as of ImageVolume

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", frozen(self.values, np.uint8))
        object.__setattr__(self, "affine", frozen(self.affine))


def write_image(image: KeptImage, path: Path) -> None:
    """Writes it as .npz without pickled objects.  Raises OSError."""
    with path.open("wb") as file:
        np.savez_compressed(
            file, allow_pickle=False, values=image.values, affine=image.affine, frame=np.array(image.frame)
        )


def read_image(path: Path) -> KeptImage:
    """The image that `write_image` wrote.  BadScan when it is damaged; OSError."""
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            return KeptImage(arrays["values"], arrays["affine"], str(arrays["frame"]))
    except (ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        raise BadScan(DAMAGED) from error
