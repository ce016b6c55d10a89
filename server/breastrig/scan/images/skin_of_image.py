"""The skin of an image: a stand-in with one threshold for the whole image."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.scan.images.image import ImageVolume
from breastrig.scan.volumes.body import Bodies, skin


@dataclass(frozen=True, eq=False)
class SeenNipple:
    """A nipple that the image shows."""

    side: Literal["L", "R"]
    place: Array  # (3,) mm, LPS
    radius_mm: float


@dataclass(frozen=True, eq=False)
class ImageSkin:
    """The skin as triangles, open where the image ends."""

    vertices: Array  # (V, 3) mm, LPS
    faces: Integers  # (F, 3)
    notes: tuple[str, ...] = ()  # one sentence each
    nipples: tuple[SeenNipple, ...] = ()


def skin_of_image(image: ImageVolume) -> ImageSkin:
    """The skin.  Raises BadScan with a sentence where there is none."""
    level = 0.25 * float(np.percentile(image.values[::2, ::2, ::2], 99.0))
    body = Bodies(np.asarray(image.values > level)).body(image.affine)
    vertices, faces = skin(body, image.affine, image.gaps)
    return ImageSkin(vertices, faces)
