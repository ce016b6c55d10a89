"""An image of one file (NIfTI, NRRD, MetaImage) in the patient's frame, or the question how it lies."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from breastrig.core.arrays import Array, Booleans
from breastrig.core.errors import BadScan
from breastrig.scan.images.image import ImageVolume
from breastrig.scan.volumes.body import Bodies
from breastrig.scan.volumes.grids.grid import Grid
from breastrig.scan.volumes.question import needs_answer
from breastrig.scan.volumes.volume import Reading, Volume

CELL = 3.0  # mm, of the pictures by which a person tells how it lies
BRIGHT = 0.15  # of the way from the 5th percentile to the 99th; more is tissue
NO_GREY = "This image shows nothing, for all its values are the same; export it again."


def image_of(grid: Grid) -> ImageVolume:
    """The image.  NeedsAnswer where it is not known how its voxels lie, BadScan for one that shows nothing."""
    readings, doubt, notes = grid.frames
    values = _sound(grid)
    if len(readings) > 1:
        coarse, shape, shown = _coarse(values, readings)
        raise needs_answer(Volume(shape, (), shown, doubt), Bodies(coarse), {})
    return ImageVolume(values, readings[0].affine, notes=notes)


def _sound(grid: Grid) -> NDArray[Any]:
    """(I, J, K) finite numbers, those that are meant."""
    values = grid.layers[0]
    if grid.slope != 1.0 or grid.intercept != 0.0:
        values = values.astype(np.float32) * np.float32(grid.slope) + np.float32(grid.intercept)
    if values.dtype.kind == "f":
        sound = np.isfinite(values)
        if not sound.any():
            raise BadScan(NO_GREY)
        values = values if sound.all() else np.where(sound, values, values[sound].min())
    if values.min() == values.max():
        raise BadScan(NO_GREY)
    return values


def _coarse(
    values: NDArray[Any], readings: tuple[Reading, ...]
) -> tuple[Booleans, tuple[int, int, int], tuple[Reading, ...]]:
    """Where tissue is on a grid of about CELL, its shape, and the readings on it."""
    steps = np.linalg.norm(readings[0].affine[:3, :3], axis=0)
    block = np.clip(np.rint(CELL / steps), 1, np.array(values.shape) // 2).astype(int)
    thinned = values[:: block[0], :: block[1], :: block[2]].astype(np.float32)
    smooth = ndimage.uniform_filter(thinned, 3)
    low, high = np.percentile(smooth, (5.0, 99.0))
    turn: Array = np.diag([*block.astype(np.float64), 1.0])
    there = np.asarray(smooth > low + BRIGHT * (high - low))
    shown = tuple(Reading(each.value, each.text, each.affine @ turn, each.is_placed) for each in readings)
    return there, (there.shape[0], there.shape[1], there.shape[2]), shown
