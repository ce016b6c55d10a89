"""Reads NIfTI: numbers on a grid, and two transforms in the header that place it.

The sform and the qform each have a code for whether they are valid. Where neither is, or both are and contradict each
other, it is not known which side is left, and a person is asked.
"""

from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from breastrig.core.arrays import Array
from breastrig.core.errors import BadScan, BadSettings
from breastrig.scan.volumes.answers import FORMS
from breastrig.scan.volumes.grids.frames import RAS_TO_LPS, SAYS_ITSELF, Frames, axis_codes, axis_words, unstated
from breastrig.scan.volumes.grids.grid import Grid, widest_axis
from breastrig.scan.volumes.volume import NOT_GREY, Reading, check_affine, check_shape

MM = {"meter": 1e3, "mm": 1.0, "micron": 1e-3}
BROKEN = "Its {} claims to hold, but has no meaning; it was not used."
NO_UNIT = "The file names no unit of length; it was read in mm, as NIfTI means it."
NEITHER = "This NIfTI file does not say which side is left (neither its sform nor its qform holds)"
CONTRADICTION = "The sform and the qform of this NIfTI file contradict each other by {}, and both claim to hold"


def read_nifti(data: bytes, frame: str | None) -> Grid:
    """The grid with its readings: one, or those among which a person has to choose.

    `frame` is the person's answer.  Raises BadScan or TooLarge; BadSettings for an answer that does not fit this file.
    """
    import nibabel

    image: Any = (nibabel.Nifti2Image if b"n+2\0" in data[4:8] else nibabel.Nifti1Image).from_bytes(data)
    header, shape = image.header, image.shape
    while len(shape) > 3 and shape[-1] == 1:
        shape = shape[:-1]
    check_shape(shape)
    frames = _readings(header, shape, frame)
    for each in frames[0]:
        check_affine(each.affine)
    stored = image.dataobj  # the header has lost these numbers
    raw = _raw(data, stored.dtype, stored.offset, shape)
    return Grid((raw,), frames, stored.slope, stored.inter, _slice_axis(header))


def _slice_axis(header: Any) -> int:
    """The axis along which slices lie: the file's, or that of the largest step, of equal ones the last."""
    named = header.get_dim_info()[2]
    return widest_axis(header.get_zooms()) if named is None else int(named)


def _raw(data: bytes, kind: np.dtype[Any], start: int, shape: tuple[int, ...]) -> NDArray[Any]:
    """(I, J, K) as stored; BadScan where they are colours."""
    if kind.kind not in "iuf":
        raise BadScan(NOT_GREY)
    return np.ndarray(shape, kind, data, start, order="F")


def _readings(header: Any, shape: tuple[int, ...], frame: str | None) -> Frames:
    """The possible readings of the voxels' frame, the reason where it is ambiguous, and notes."""
    try:
        mm = MM.get(header.get_xyzt_units()[0])
    except KeyError:  # a number that stands for nothing
        mm = None
    notes: tuple[str, ...] = () if mm is not None else (NO_UNIT,)
    notes += tuple(BROKEN.format(name) for name in FORMS if header[f"{name}_code"] > 0 and _form(header, name) is None)
    to_lps = np.diag([1.0 if mm is None else mm] * 3 + [1.0]) @ RAS_TO_LPS
    forms = {name: to_lps @ form for name in FORMS if (form := _form(header, name)) is not None}
    if not forms:
        sizes = np.abs(np.asarray(header.get_zooms()[:3], np.float64)) * (1.0 if mm is None else mm)
        readings, doubt, chosen = unstated(NEITHER, sizes, shape, frame)
        return readings, doubt, (*notes, *chosen)
    known = {
        name: Reading(name, f"as its {name} says, axes to {axis_words(form)}", form) for name, form in forms.items()
    }
    if frame in known:
        others = [name for name in known if name != frame and _difference(forms[name], forms[frame], shape)]
        return (
            (known[frame],),
            "",
            (*notes, *(f"Its {name} contradicts the {frame}, which was taken." for name in others)),
        )
    if frame is not None:
        same = [name for name, form in forms.items() if axis_codes(form) == frame]
        if not same:
            own = " and ".join(f"{name} {axis_codes(form)}" for name, form in forms.items())
            raise BadSettings(SAYS_ITSELF.format(own, frame))
        return (known[same[0]],), "", notes
    if len(forms) == 2 and (by := _difference(forms["sform"], forms["qform"], shape)):
        return tuple(known.values()), CONTRADICTION.format(by), notes
    return (next(iter(known.values())),), "", notes


def _form(header: Any, name: str) -> Array | None:
    """(4, 4) RAS in the file's unit, where the file says that it holds and it can be used."""
    try:
        form, code = header.get_sform(coded=True) if name == "sform" else header.get_qform(coded=True)
    except Exception:  # quaternions of no turn
        return None
    is_usable = form is not None and np.isfinite(form).all() and abs(np.linalg.det(form[:3, :3])) > 0.0
    return np.asarray(form, np.float64) if code > 0 and is_usable else None


def _difference(one: Array, other: Array, shape: tuple[int, ...]) -> str:
    """The difference between two affines in words; empty where no voxel moves by more than its size."""
    corners = np.array(list(product(*((0, size - 1) for size in shape)))) @ (one - other)[:3, :3].T
    farthest = float(np.linalg.norm(corners + (one - other)[:3, 3], axis=1).max())
    if np.linalg.det(one[:3, :3]) * np.linalg.det(other[:3, :3]) < 0.0:
        return f"left and right ({axis_codes(one)} and {axis_codes(other)})"
    return f"{farthest:.3g} mm" if farthest > np.linalg.norm(one[:3, :3], axis=0).max() else ""
