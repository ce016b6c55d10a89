"""Voxels that follow a text header in the same file (NRRD, MetaImage).

A header may name other files instead; those are never opened: whoever sends the header could have any file read.
"""

import math
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from breastrig.core.errors import BadScan, TooLarge
from breastrig.scan.limits import LABEL_MAP_BYTES, MEBIBYTE
from breastrig.scan.volumes.gzipped import VOXELS_DAMAGED, inflated

HEADER_BYTES = 2**20  # a text header with the words of some thousand segments
WHOLE = re.compile(r"-?[0-9]{1,12}")
DETACHED = "This header names another file for its voxels, which is never opened; save both as one file ({})."
NO_HEADER = "The header of this {} file is damaged or cut off; export it again."


def voxels(data: bytes, start: int, sizes: tuple[int, ...], dtype: np.dtype[Any], is_packed: bool) -> NDArray[Any]:
    """The numbers from byte `start` on, the first of `sizes` fastest.  BadScan, or TooLarge before anything is made."""
    size = math.prod(sizes) * dtype.itemsize
    if size > LABEL_MAP_BYTES:
        raise TooLarge(f"The voxels of this file have more than the {LABEL_MAP_BYTES // MEBIBYTE} MB allowed; crop it.")
    content, at = (inflated(data[start:], size), 0) if is_packed else (data, start)
    if len(content) - at < size:
        raise BadScan(VOXELS_DAMAGED)
    return np.ndarray(sizes, dtype, content, at, order="F")


def whole_numbers(text: str) -> tuple[int, ...] | None:
    """The whole numbers of a line; None where it holds anything else, or absurd ones."""
    words = text.split()
    return tuple(int(word) for word in words) if words and all(WHOLE.fullmatch(word) for word in words) else None


def decimal_numbers(text: str) -> list[float] | None:
    """The numbers of a line, which may be NaN; None where it holds anything else."""
    try:
        return [float(word) for word in text.split()]
    except ValueError:
        return None
