"""An image as read, and what of it is kept: voxels averaged until they are few enough."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array
from breastrig.core.stances import Stance
from breastrig.scan.kept_image import KEPT_BYTES, KeptImage
from breastrig.scan.volumes.volume import Gap

DARKEST, LIGHTEST = 0.5, 99.8  # percentiles of the values that become 0 and 255
SAMPLED = 2_000_000  # voxels of which they are taken


@dataclass(frozen=True, eq=False)
class ImageVolume:
    """Grey values on one grid of voxels; nothing else of the file's headers."""

    values: NDArray[Any]  # (I, J, K) whole numbers or floats, finite; larger is lighter
    affine: Array  # (4, 4) indices of a voxel's middle to mm, the DICOM patient frame (LPS)
    frame: str = ""  # digest of the file's frame of reference; empty where it names none
    gaps: tuple[Gap, ...] = ()  # slices of which nothing is known
    notes: tuple[str, ...] = ()  # one sentence each
    stance: Stance | None = None  # that the file's header states


def kept_image(image: ImageVolume) -> KeptImage:
    """Voxels averaged in blocks, as nearly cubes as may be, until they are few enough."""
    values, steps = image.values, np.linalg.norm(image.affine[:3, :3], axis=0)
    sample = values.ravel(order="K")[:: max(1, values.size // SAMPLED)]
    low, high = (float(each) for each in np.percentile(sample, (DARKEST, LIGHTEST)))
    block = np.ones(3, np.int64)
    while np.prod(np.array(values.shape) // block) > KEPT_BYTES:
        block[int(np.argmin(steps * block))] += 1
    kept = np.array(values.shape) // block  # a last block that is not whole is left out
    whole = values[tuple(slice(0, int(n * b)) for n, b in zip(kept, block, strict=True))]
    grey = np.zeros(tuple(kept), np.uint8, order="F")
    for k in range(int(kept[2])):  # slab by slab: a copy of all of it as floats would be 1 GB
        slab = whole[:, :, k * block[2] : (k + 1) * block[2]].astype(np.float32)
        mean = slab.reshape(kept[0], block[0], kept[1], block[1], block[2]).mean(axis=(1, 3, 4))
        grey[:, :, k] = np.round(np.clip((mean - low) * (255.0 / max(high - low, 1e-12)), 0.0, 255.0))
    turn = np.diag([*block.astype(np.float64), 1.0])
    turn[:3, 3] = 0.5 * (block - 1)
    return KeptImage(grey, image.affine @ turn, image.frame)
