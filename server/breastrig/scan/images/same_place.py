"""Whether lesions of another file lie in an image: as the files say, as their grids show, and in tissue, not in air."""

import base64
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from scipy import ndimage

from breastrig.core.arrays import Array, Booleans
from breastrig.core.errors import NeedsAnswer
from breastrig.scan.kept_image import KeptImage
from breastrig.scan.piece import BallInside
from breastrig.scan.volumes.volume import Box

AIR_SLABS = 3  # voxels from the front, which are air
TIMES_AIR = 1.5  # of their 90th percentile: tissue has more
LEAST_GREY = 3.0  # of 255; air that the scanner set to 0
MOST_IN_AIR = 0.5  # share of a lesion
PIXELS = 200  # of the picture's longer side
SHIFTED = "The grid of these lesions is the image's, moved by {:.0f} mm"
OTHER_FRAME = "These lesions were drawn in another frame of reference than the image's"
IN_AIR = "{} lies {} of the image"
YES = "they lie there; the picture shows it"
NO = "they do not lie there"


@dataclass(frozen=True, eq=False)
class Tissue:
    """Where an image shows something, or what lies behind it as seen from the front."""

    inside: Booleans  # (I, J, K) voxels of the image
    to_voxels: Array  # (4, 4) mm, LPS, to their indices

    def at(self, places: Array) -> tuple[Booleans, Booleans]:
        """Of each of (N, 3) mm whether it lies within the image, and there not in air."""
        index = np.rint(places @ self.to_voxels[:3, :3].T + self.to_voxels[:3, 3]).astype(np.int64)
        within = np.all((index >= 0) & (index < self.inside.shape), axis=1)
        index = np.clip(index, 0, np.array(self.inside.shape) - 1)
        return np.asarray(within), np.asarray(within & self.inside[index[:, 0], index[:, 1], index[:, 2]])

    def on(self, affine: Array) -> Callable[[Box], Booleans]:
        """The same for boxes of a grid with this affine (to mm, LPS); beyond the image all is tissue."""
        turn = self.to_voxels @ affine

        def inside(box: Box) -> Booleans:
            start = turn[:3, :3] @ [side.start for side in box] + turn[:3, 3]
            shape = tuple(side.stop - side.start for side in box)
            found = ndimage.affine_transform(
                self.inside.astype(np.uint8), turn[:3, :3], start, shape, order=0, mode="constant", cval=1
            )
            return np.asarray(found > 0)

        return inside


def tissue_of(image: KeptImage) -> Tissue:
    """Everything from the first tissue on that the front of the image shows; faded backs and lungs are no air."""
    smooth = ndimage.uniform_filter(image.values.astype(np.float32), 3)
    axis = int(np.abs(image.affine[1, :3]).argmax())
    from_front = np.moveaxis(smooth, axis, 0)
    is_turned = image.affine[1, axis] < 0.0  # LPS: y grows to the back
    from_front = from_front[::-1] if is_turned else from_front
    level = max(TIMES_AIR * float(np.percentile(from_front[:AIR_SLABS], 90)), LEAST_GREY)
    seen = np.maximum.accumulate(ndimage.binary_opening(from_front > level), axis=0)
    return Tissue(
        np.moveaxis(seen[::-1] if is_turned else seen, 0, axis), np.asarray(np.linalg.inv(image.affine), np.float64)
    )


def doubt_of_place(lesions: Sequence[BallInside], tissue: Tissue) -> tuple[str, BallInside] | None:
    """A sentence's beginning and the lesion that it is about, where one lies in air or beyond the image."""
    ball = np.array([each for each in product((-1.0, 0.0, 1.0), repeat=3) if np.linalg.norm(each) < 1.5])
    for each in lesions:
        within, inside = tissue.at(each.center + 0.6 * each.radius * ball)
        if inside.mean() < 1.0 - MOST_IN_AIR:
            return IN_AIR.format(each.name, "in the air" if within.mean() > 0.5 else "outside"), each
    return None


def shift_of(affine: Array, shape: tuple[int, ...], image: KeptImage) -> float | None:
    """mm between a grid and that of which the image was kept, and 0 if less than a slice; None for another grid.

    The image's voxels may be blocks of those of the grid, whose axes may have another order.
    """
    sizes, kept = (np.linalg.norm(each[:3, :3], axis=0) for each in (affine, image.affine))
    cosines = (image.affine[:3, :3] / kept).T @ (affine[:3, :3] / sizes)
    order = np.abs(cosines).argmax(axis=1)
    if len(set(order.tolist())) < 3 or np.abs(cosines[np.arange(3), order]).min() < 1.0 - 1e-4:
        return None
    block = kept / sizes[order]
    whole, counts = np.rint(block), np.asarray(shape)[order]
    if np.abs(block - whole).max() > 0.01 * whole.max() or (counts // np.maximum(whole, 1) != image.values.shape).any():
        return None
    first = np.where(cosines[np.arange(3), order] > 0.0, 0.5 * (whole - 1), counts - 1 - 0.5 * (whole - 1))
    index = np.zeros(3)
    index[order] = first
    moved = float(np.linalg.norm(affine[:3, :3] @ index + affine[:3, 3] - image.affine[:3, 3]))
    return moved if moved > sizes.max() else 0.0


def same_place_question(problem: str, lesion: BallInside, image: KeptImage) -> NeedsAnswer:
    """The error that asks, with the lesion on the image's slice."""
    picture = _picture(lesion, image)
    choices = [{"value": "yes", "text": YES, "picture": picture}, {"value": "no", "text": NO}]
    return NeedsAnswer(problem, {"field": "same_place", "choices": choices})


def _picture(lesion: BallInside, image: KeptImage) -> str:
    """The slice through the lesion's middle, seen from the feet as radiology has it, or the nearest: a PNG as data
    address."""
    up = int(np.abs(image.affine[2, :3]).argmax())
    left = int(np.abs(np.where(np.arange(3) == up, 0.0, image.affine[0, :3])).argmax())
    back = 3 - up - left
    at = np.linalg.inv(image.affine) @ [*lesion.center, 1.0]
    number = int(np.clip(round(at[up]), 0, image.values.shape[up] - 1))
    grey: NDArray[np.uint8] = np.moveaxis(image.values, (back, left, up), (0, 1, 2))[:, :, number]
    sizes = np.linalg.norm(image.affine[:3, :3], axis=0)[[back, left]]
    place = at[[back, left]]
    for axis, (which, row) in enumerate(((back, 1), (left, 0))):
        if image.affine[row, which] < 0.0:
            grey, place[axis] = np.flip(grey, axis), grey.shape[axis] - 1 - place[axis]
    scale = PIXELS / float((sizes * grey.shape).max())
    height, width = (max(16, round(scale * each)) for each in sizes * grey.shape)
    shown = Image.fromarray(np.ascontiguousarray(grey)).convert("RGB").resize((width, height))
    y, x = np.clip(scale * sizes * (place + 0.5), 0.0, (height - 1, width - 1))
    radius = max(4.0, scale * lesion.radius)
    draw = ImageDraw.Draw(shown)
    draw.ellipse((x - radius, y - radius, x + radius, y + radius), outline=(255, 40, 40), width=2)
    draw.text((2, height - 12), "R", fill=(255, 255, 255))
    draw.text((width - 9, height - 12), "L", fill=(255, 255, 255))
    stream = io.BytesIO()
    shown.save(stream, "PNG")
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode()
