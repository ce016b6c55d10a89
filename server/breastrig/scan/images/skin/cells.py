"""An MR image averaged to cells of some 2 mm, and what in it is body: all that the air in front does not reach.

One threshold for the whole image fails, for coils fade: tissue is what has a share of the strongest signal nearby.
Ghosts of motion and the patient's board have none of the strongest signal further around; ghosts are copies along an
axis, so they have a small share of the strongest there.  Behind where even that fades into noise nothing is known.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.core.errors import BadScan
from breastrig.scan.images.image import ImageVolume

Grey = NDArray[np.float32]

CELL, FINE = 2.0, 0.85  # mm, and the share of it under which blocks of voxels are too small
COARSE = 4.0  # mm, of the maxima's grid
NEAR, WIDE = 14.0, 40.0  # mm to each side, in which the strongest signal is looked for
ISO = 0.25  # of the strongest nearby: half of skin beside bright fat, its edge
LEAST = 0.12  # of the strongest within WIDE
OF_ROW = 0.15  # of the strongest along an axis from side to side, or from feet to head: ghosts have 0.1
SEEN = 2.0  # times what noise is hardly above: the strongest at a depth at which the image still shows tissue
SMOOTH = 3.0  # mm, Gaussian that closes holes through which air would enter
DEVIATIONS = 4.0  # of the air's noise over its middle
DARK = 0.12  # of the image's strongest: what may be air
SURELY_AIR = 0.01  # share of the cells that is dark at least
CUT = 0.2  # share of zeros from which the scanner has set its air to 0, and tells no noise
SAMPLED = 200_000  # cells
DENSEST, GOLDEN = 500, 0.618034  # values whose mean is the mode; a step that fills an interval evenly
REGAIN = 10.0  # mm that air may advance into what only the smoothed image closes
PIECE = 0.4  # of the largest piece's size: a second breast, no arm
NO_AIR = "This image shows no skin with air in front of it; give a whole breast MRI, from the air to the chest wall."


@dataclass(frozen=True, eq=False)
class Cells:
    """The averaged image and its thresholds."""

    values: Grey  # (I, J, K)
    level: Grey  # (I, J, K) at the skin's edge
    ghost: Grey  # the most that a ghost has, with axes of length 1
    closed: Booleans  # (I, J, K) tissue in the smoothed image
    faded: Booleans  # from where on backwards nothing is known, with axes of length 1
    affine: Array  # (4, 4) cells' indices to mm, LPS

    @property
    def sizes(self) -> Array:
        """(3,) mm"""
        return np.asarray(np.linalg.norm(self.affine[:3, :3], axis=0))

    def indices(self, points: Array) -> Array:
        """(..., 3) of cells, of (..., 3) mm."""
        inverse = np.linalg.inv(self.affine)
        return np.asarray(points @ inverse[:3, :3].T + inverse[:3, 3])

    def sampled(self, grey: Grey, points: Array) -> Array:
        """(N,) values of a grid like this one at (N, 3) mm."""
        at = self.indices(points)
        return np.asarray(ndimage.map_coordinates(grey, at.T, order=1, mode="nearest", output=np.float64))


def cells_of(image: ImageVolume) -> Cells:
    """Raises BadScan where nothing is dark enough for air."""
    steps = np.linalg.norm(image.affine[:3, :3], axis=0)
    block = np.clip(np.round(CELL / steps), 1, image.values.shape).astype(np.int64)
    grey = _averaged(image, block)
    averaged = np.array(grey.shape)
    counts = np.where(steps * block < FINE * CELL, np.round((averaged - 1) * steps * block / CELL) + 1, averaged)
    if (counts < averaged).any():
        grey = ndimage.zoom(grey, counts / averaged, order=1)  # from middle to middle of the outermost
    scale = block * (averaged - 1) / np.maximum(np.array(grey.shape) - 1, 1)
    turn = np.diag([*scale, 1.0])
    turn[:3, 3] = 0.5 * (block - 1)
    sizes = steps * scale
    strongest = float(np.percentile(grey, 99.5))
    if min(grey.shape) < 2 or (grey < DARK * strongest).mean() < SURELY_AIR:
        raise BadScan(NO_AIR)
    noise, near, wide = _noise(grey, strongest), _strongest(grey, sizes, NEAR), _strongest(grey, sizes, WIDE)
    level = np.maximum(np.maximum(np.float32(ISO) * near, np.float32(LEAST) * wide), np.float32(noise))
    smooth = ndimage.gaussian_filter(grey, SMOOTH / sizes)
    quiet = np.float32(_noise(smooth, strongest))
    axes = [int(np.abs(image.affine[row, :3]).argmax()) for row in range(3)]
    ghost = np.float32(OF_ROW) * np.maximum(*(smooth.max(axis=axes[row], keepdims=True) for row in (0, 2)))
    closed = smooth > np.maximum(np.maximum(quiet, np.float32(LEAST) * wide), ghost)
    return Cells(grey, level, ghost, closed, _faded(smooth, noise, axes[1], image.affine), image.affine @ turn)


def body_in(cells: Cells) -> Booleans:
    """(I, J, K), without holes, as far back as it is seen.  Raises BadScan where no air or no body is seen."""
    tissue = (cells.values > np.maximum(cells.level, cells.ghost)) | cells.faded
    axis = int(np.abs(cells.affine[1, :3]).argmax())
    air: NDArray[Any] = ndimage.label(~(tissue | cells.closed))[0]
    in_front = air.take(0 if cells.affine[1, axis] > 0.0 else -1, axis=axis)  # LPS: y grows to the back
    counts = np.bincount(in_front[in_front > 0])
    if not counts.size:
        raise BadScan(NO_AIR)
    steps = max(1, round(REGAIN / float(cells.sizes.mean())))
    reached = ndimage.binary_dilation(air == counts.argmax(), iterations=steps, mask=~tissue)
    pieces: NDArray[Any] = ndimage.label(~(reached | cells.faded))[0]
    sizes = np.bincount(pieces.ravel())
    sizes[0] = 0
    if not sizes.any():
        raise BadScan(NO_AIR)
    return np.asarray((sizes >= PIECE * sizes.max())[pieces])


def _faded(smooth: Grey, noise: float, axis: int, affine: Array) -> Booleans:
    """Of each depth (axis `axis`, the others of length 1) whether it lies behind all that is seen.  Raises BadScan."""
    strongest = smooth.max(axis=tuple(each for each in range(3) if each != axis))
    at, seen = np.arange(len(strongest)), np.flatnonzero(strongest > SEEN * noise)
    if not len(seen):
        raise BadScan(NO_AIR)
    behind = at > seen[-1] if affine[1, axis] > 0.0 else at < seen[0]
    return np.asarray(behind.reshape([-1 if each == axis else 1 for each in range(3)]))


def _averaged(image: ImageVolume, block: Integers) -> Grey:
    """Slab by slab, for a copy of it all as floats is too much; missing slices lie between their neighbours."""
    counts = np.array(image.values.shape) // block  # a last block that is not whole is left out
    whole = image.values[tuple(slice(0, int(n * b)) for n, b in zip(counts, block, strict=True))]
    grey = np.zeros(tuple(counts), np.float32)
    for k in range(int(counts[2])):
        slab = whole[:, :, k * block[2] : (k + 1) * block[2]].astype(np.float32)
        grey[:, :, k] = slab.reshape(counts[0], block[0], counts[1], block[1], block[2]).mean(axis=(1, 3, 4))
    lowest = float(np.percentile(grey, 0.1))
    if lowest < 0.0:
        grey -= np.float32(lowest)
    for gap in image.gaps:
        slices = np.moveaxis(grey, gap.axis, 0)
        before, after = gap.first // block[gap.axis] - 1, gap.last // block[gap.axis] + 1
        for at in range(max(before + 1, 0), min(after, len(slices))):
            low, high = slices[max(before, 0)], slices[min(after, len(slices) - 1)]
            slices[at] = low + (high - low) * np.float32((at - before) / (after - before))
    return grey


def _noise(grey: Grey, strongest: float) -> float:
    """What noise in air is hardly above: the densest of the dark values, and the spread of those below it."""
    if (grey == 0.0).mean() > CUT:
        return 0.0
    dark = grey[(grey < DARK * strongest) & (grey > 0.0)]
    dark = dark[:: max(1, len(dark) // SAMPLED)]
    if not len(dark):
        return 0.0
    between = np.diff(np.unique(dark))  # whole numbers lie on each other: spread to where they were rounded from
    spread = float(np.percentile(between, 10)) if len(between) else 0.0
    dark = np.sort(dark + spread * (np.arange(len(dark)) * GOLDEN % 1.0 - 0.5))
    part = dark
    while len(part) > DENSEST:
        half = len(part) // 2
        start = int((part[half:] - part[: len(part) - half]).argmin())
        part = part[start : start + half]
    middle = float(part.mean())
    return middle + DEVIATIONS * float(np.median(middle - dark[dark <= middle])) / 0.6745


def _strongest(grey: Grey, sizes: Array, reach: float) -> Grey:
    """(I, J, K) the strongest within `reach` mm along each axis, smoothed."""
    step = np.clip(np.round(COARSE / sizes), 1, grey.shape).astype(np.int64)
    padded = np.pad(grey, [(0, int(-size % s)) for size, s in zip(grey.shape, step, strict=True)], "edge")
    blocks = padded.reshape([n for size, s in zip(padded.shape, step, strict=True) for n in (size // s, s)])
    coarse, cells = blocks.mean(axis=(1, 3, 5), dtype=np.float32), reach / (sizes * step)
    spread: Grey = ndimage.maximum_filter(coarse, [2 * max(1, round(each)) + 1 for each in cells])
    spread = ndimage.gaussian_filter(spread, 0.35 * cells, mode="nearest")
    for axis, (size, s) in enumerate(zip(grey.shape, step, strict=True)):
        at = (np.arange(size) - 0.5 * (s - 1)) / s
        low = np.clip(np.floor(at), 0, max(spread.shape[axis] - 2, 0)).astype(np.int64)
        high = np.minimum(low + 1, spread.shape[axis] - 1)
        share = np.clip(at - low, 0.0, 1.0).astype(np.float32).reshape([-1 if k == axis else 1 for k in range(3)])
        spread = spread.take(low, axis) * (1 - share) + spread.take(high, axis) * share
    return spread
