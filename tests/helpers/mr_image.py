"""An MR-like image of a synthetic woman, small enough for tests."""

from dataclasses import replace
from functools import cache

from breastrig_studies.virtual.magnetic.image import OPTIONS, PLAIN, MrImage
from breastrig_studies.virtual.magnetic.image import mr_image as image_of
from breastrig_studies.virtual.magnetic.woman import prone_woman
from helpers.remembered import key_of, once

NAMES = (*OPTIONS, "arms touch")


@cache
def mr_image(option: str = "plain", seed: int = 2, step: float = 3.0) -> MrImage:
    """Of this seed's woman, one of NAMES, voxels of `step` mm (slices of 3 mm where the option says so)."""

    def made() -> MrImage:
        woman = prone_woman(seed, "beside" if option == "arms touch" else "raised")
        protocol = replace(PLAIN, steps=(step, step, step))
        return image_of(woman, OPTIONS.get(option, OPTIONS["plain"])(protocol), seed)

    found: MrImage = once(key_of("mr_image", option, seed, step), made)
    return found
