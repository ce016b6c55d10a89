"""The frame of a grid's voxels: stated by its file, or asked."""

from itertools import permutations, product
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadSettings
from breastrig.scan.volumes.answers import FORMS
from breastrig.scan.volumes.volume import Reading

RAS_TO_LPS = np.diag([-1.0, -1.0, 1.0, 1.0])
WORDS = {"L": "left", "R": "right", "A": "front", "P": "back", "S": "head", "I": "feet"}
SAID = "Where the voxels lie was said by a person ({}), for the file does not say it{}."
SAYS_ITSELF = "This file says itself where its voxels lie ({}), and not as {}; leave frame out."
Frames = tuple[tuple[Reading, ...], str, tuple[str, ...]]  # readings, why there are several, notes


def stated(affine: Array, frame: str | None, is_placed: bool = True) -> Frames:
    """The one reading of a file that states its affine (4, 4) to LPS; BadSettings for another answer."""
    if frame is not None and frame != axis_codes(affine):
        raise BadSettings(SAYS_ITSELF.format(axis_codes(affine), frame))
    return (Reading("", "", affine, is_placed),), "", ()


def unstated(why: str, sizes: Array, shape: tuple[int, ...], frame: str | None) -> Frames:
    """All readings of a file that does not say which side is left, or the one that a person has chosen.

    `sizes` (3,) mm; `why` begins the sentence, "This file does not say ...".
    """
    if frame is None:
        return tuple(_along(codes, sizes, shape) for codes in _all_axis_codes()), why, ()
    if frame in FORMS:
        raise BadSettings(f"{why}, so that there is no {frame} to be taken; give three letters, such as RAS.")
    return (_along(frame, sizes, shape),), "", (SAID.format(frame, "; the volume's middle was put at 0"),)


def axis_codes(affine: Array) -> str:
    """Axis codes of an affine in LPS, such as "RAS"."""
    from nibabel.orientations import aff2axcodes

    found: Any = aff2axcodes(RAS_TO_LPS @ affine)
    return "".join(map(str, found))


def axis_words(affine: Array) -> str:
    """The same in words: "right, front, head"."""
    return ", ".join(WORDS[letter] for letter in axis_codes(affine))


def _all_axis_codes() -> list[str]:
    """All 48 axis codes; those of axial slices first, and of these those towards the head."""
    return sorted(
        ("".join(letters) for axes in permutations(("RL", "AP", "SI")) for letters in product(*axes)),
        key=lambda codes: ((codes[0] not in "RL") + (codes[2] not in "SI"), "I" in codes),
    )


def _along(codes: str, sizes: Array, shape: tuple[int, ...]) -> Reading:
    """The reading with these axis codes and the volume's middle at 0."""
    turn = np.zeros((3, 3))
    for axis, letter in enumerate(codes):
        turn["LPSRAI".index(letter) % 3, axis] = (1.0 if letter in "LPS" else -1.0) * sizes[axis]
    affine = np.eye(4)
    affine[:3, :3], affine[:3, 3] = turn, -0.5 * turn @ (np.asarray(shape) - 1.0)
    return Reading(codes, f"axes to {', '.join(WORDS[letter] for letter in codes)}", affine, is_placed=False)
