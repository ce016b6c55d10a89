"""A chest with two half balls as an MR image of 94 x 60 x 40 voxels: enough to be read, and quick."""

from functools import cache

import numpy as np

from breastrig.scan.images.image import ImageVolume

SIZES, LOW, SHAPE = np.array([3.0, 3.2, 4.0]), np.array([-140.0, -90.0, 60.0]), (94, 60, 40)  # mm, LPS
FRONT = -65.0  # mm, the most that it reaches to the front
LEFT, RIGHT = np.array([65.0, -5.0, 140.0]), np.array([-65.0, -5.0, 140.0])


@cache
def chest_image() -> ImageVolume:
    """Axial; the left ball is lighter."""
    at = np.stack(np.meshgrid(*[LOW[k] + SIZES[k] * np.arange(SHAPE[k]) for k in range(3)], indexing="ij"), axis=-1)
    body = (at[..., 1] > 0.0).astype(np.float64)
    for centre, light in ((LEFT, 1.3), (RIGHT, 1.0)):
        body[np.linalg.norm(at - centre, axis=-1) < -FRONT + centre[1]] = light
    rng = np.random.default_rng(1)
    values = np.hypot(600.0 * body + rng.normal(0, 8, SHAPE), rng.normal(0, 8, SHAPE)).astype(np.uint16)
    affine = np.diag([*SIZES, 1.0])
    affine[:3, 3] = LOW
    return ImageVolume(values, affine, "")
