"""sRGB and linear light (IEC 61966-2-1), both from 0 to 1."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[np.floating[Any]]


def to_light(colours: Reals) -> Reals:
    """Linear light of sRGB; whatever is below zero as steep as zero."""
    return np.where(colours <= 0.04045, colours / 12.92, ((np.maximum(colours, 0.0) + 0.055) / 1.055) ** 2.4)


def to_srgb(light: Reals) -> Reals:
    """sRGB of linear light, cut at black and white."""
    light = np.clip(light, 0.0, 1.0)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def rgb(color: str) -> tuple[int, int, int]:
    """0 to 255 of "#rrggbb"."""
    red, green, blue = bytes.fromhex(color.removeprefix("#"))
    return red, green, blue
