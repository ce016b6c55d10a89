"""Reads label maps in NIfTI: whole numbers on a grid, and two transforms in the header that place it.

The sform and the qform each have a code for whether they are valid. Where neither is, or both are and contradict each
other, it is not known which side is left, and a person is asked.
"""

from functools import partial
from itertools import permutations, product
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from breastrig.core.arrays import Array, Booleans
from breastrig.core.errors import BadScan, BadSettings
from breastrig.scan.limits import LABELS
from breastrig.scan.volumes.answers import FORMS
from breastrig.scan.volumes.slices import bridged_labels, gaps_said
from breastrig.scan.volumes.volume import IMAGE, Reading, Segment, Volume, check_affine, check_shape

WHOLE = 0.02  # farthest from a whole number that a label is stored as
FARTHEST = 0.4  # the same of labels that were scaled to 255 or 65,535 levels, half a level at most
FEW = 20  # labels; of more it is asked whether they are areas
AREAS = 0.5  # share of neighbours within the body that have the same label; 0.9 in label maps, 0.1 in images
LARGEST_LABEL = 65_535
SLAB = 2**22  # voxels looked at together
RAS_TO_LPS = np.diag([-1.0, -1.0, 1.0, 1.0])
MM = {"meter": 1e3, "mm": 1.0, "micron": 1e-3}
BROKEN = "Its {} claims to hold, but has no meaning; it was not used."
NO_UNIT = "The file names no unit of length; it was read in mm, as NIfTI means it."
EMPTY = "{} between others was filled from the neighbours."
NO_NUMBER = "Voxels without a number (NaN) were taken for air."
WORDS = {"L": "left", "R": "right", "A": "front", "P": "back", "S": "head", "I": "feet"}
NEITHER = "This NIfTI file does not say which side is left (neither its sform nor its qform holds)"
CONTRADICTION = "The sform and the qform of this NIfTI file contradict each other by {}, and both claim to hold"
SAID = "Where the voxels lie was said by a person ({}), for the file does not say it{}."


def read_nifti(data: bytes, frame: str | None) -> Volume:
    """The volume with its readings: one, or those among which a person has to choose.

    `frame` is the person's answer.  Raises BadScan or TooLarge; BadSettings for an answer that does not fit this file.
    """
    import nibabel

    image: Any = (nibabel.Nifti2Image if b"n+2\0" in data[4:8] else nibabel.Nifti1Image).from_bytes(data)
    header, shape = image.header, image.shape
    while len(shape) > 3 and shape[-1] == 1:
        shape = shape[:-1]
    check_shape(shape)
    readings, doubt, notes = _readings(header, shape, frame)
    for each in readings:
        check_affine(each.affine)
    stored = image.dataobj  # the header has lost these numbers
    labels, values, has_nan = _labels(_raw(data, stored.dtype, stored.offset, shape), stored.slope, stored.inter)
    _check_areas(labels, len(values))
    count, gaps = bridged_labels(labels, _slice_axis(header))
    boxes = ndimage.find_objects(labels, max_label=len(values) - 1)
    counts = np.bincount(labels.ravel(order="K"), minlength=len(values))
    segments = [
        Segment(value, (box[0], box[1], box[2]), int(counts[code]), partial(_inside, labels, box, code))
        for code, (value, box) in enumerate(zip(values[1:], boxes, strict=True), 1)
        if box is not None
    ]
    notes += (NO_NUMBER,) if has_nan else ()
    notes += (EMPTY.format("An empty slice" if count == 1 else f"{count} empty slices"),) if count else ()
    notes += gaps_said(gaps)
    return Volume(labels.shape, tuple(sorted(segments, key=lambda each: each.number)), readings, doubt, notes, gaps)


def _slice_axis(header: Any) -> int:
    """The axis along which slices lie: the file's, or that of the largest step, of equal ones the last."""
    named = header.get_dim_info()[2]
    return 2 - int(np.argmax(header.get_zooms()[2::-1])) if named is None else int(named)


def _inside(labels: NDArray[np.uint8], box: tuple[slice, ...], code: int) -> Booleans:
    return np.asarray(labels[box] == code)


def _raw(data: bytes, kind: np.dtype[Any], start: int, shape: tuple[int, ...]) -> NDArray[Any]:
    """(I, J, K) as stored; BadScan where they are colours."""
    if kind.kind not in "iuf":
        raise BadScan(IMAGE)
    return np.ndarray(shape, kind, data, start, order="F")


def _labels(raw: NDArray[Any], slope: float, intercept: float) -> tuple[NDArray[np.uint8], list[int], bool]:
    """(I, J, K) codes, the label of each code, the first of them 0, and whether there was NaN; BadScan for an image."""
    near = float(np.clip(0.51 * abs(slope), WHOLE, FARTHEST)) if raw.dtype.kind in "iu" else WHOLE
    is_whole = raw.dtype.kind in "iu" and slope == 1.0 and intercept == 0.0
    codes = np.zeros(raw.shape, np.uint8, order="F")
    values, has_nan = [0], False
    step = max(1, SLAB // (raw.shape[0] * raw.shape[1]))
    for start in range(0, raw.shape[2], step):
        slab = raw[:, :, start : start + step]
        if not is_whole:
            numbers = slab.astype(np.float64) * slope + intercept
            missing = np.isnan(numbers)
            if missing.any():
                has_nan, numbers[missing] = True, 0.0
            slab = np.rint(numbers)
            if not np.abs(numbers - slab).max() <= near:  # true for what is infinite, too
                raise BadScan(IMAGE)
        here = np.unique(slab)
        if len(here) > LABELS or max(-float(here[0]), float(here[-1])) > LARGEST_LABEL:
            raise BadScan(IMAGE)
        values += [int(value) for value in here if int(value) not in values]
        if len(values) > LABELS:
            raise BadScan(IMAGE)
        order = np.argsort(values)
        codes[:, :, start : start + step] = order[np.searchsorted(np.asarray(values)[order], slab)]
    return codes, values, has_nan


def _check_areas(labels: NDArray[np.uint8], count: int) -> None:
    """BadScan for an image of no more grey values than a label map may have."""
    one, other = labels[1:], labels[:-1]
    both = (one > 0) & (other > 0)
    if count > FEW and np.count_nonzero(both & (one == other)) < AREAS * np.count_nonzero(both):
        raise BadScan(IMAGE)


def _readings(
    header: Any, shape: tuple[int, ...], frame: str | None
) -> tuple[tuple[Reading, ...], str, tuple[str, ...]]:
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
        said = NEITHER
        if frame is None:
            return tuple(_along(codes, sizes, shape) for codes in _axis_codes()), NEITHER, notes
        if frame in FORMS:
            raise BadSettings(f"{NEITHER}, so that there is no {frame} to be taken; give three letters, such as RAS.")
        said = SAID.format(frame, "; the volume's middle was put at 0")
        return (_along(frame, sizes, shape),), "", (*notes, said)
    known = {name: Reading(name, f"as its {name} says, axes to {_axes(form)}", form) for name, form in forms.items()}
    if frame in known:
        others = [name for name in known if name != frame and _difference(forms[name], forms[frame], shape)]
        return (
            (known[frame],),
            "",
            (*notes, *(f"Its {name} contradicts the {frame}, which was taken." for name in others)),
        )
    if frame is not None:
        same = [name for name, form in forms.items() if _codes(form) == frame]
        if not same:
            own = " and ".join(f"{name} {_codes(form)}" for name, form in forms.items())
            raise BadSettings(
                f"This file says itself where its voxels lie ({own}), and not as {frame}; leave frame out."
            )
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
        return f"left and right ({_codes(one)} and {_codes(other)})"
    return f"{farthest:.3g} mm" if farthest > np.linalg.norm(one[:3, :3], axis=0).max() else ""


def _codes(affine: Array) -> str:
    """Axis codes of an affine in LPS, such as "RAS"."""
    from nibabel.orientations import aff2axcodes

    found: Any = aff2axcodes(RAS_TO_LPS @ affine)  # type: ignore[no-untyped-call]
    return "".join(map(str, found))


def _axes(affine: Array) -> str:
    return ", ".join(WORDS[letter] for letter in _codes(affine))


def _axis_codes() -> list[str]:
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
    return Reading(codes, f"axes to {', '.join(WORDS[letter] for letter in codes)}", affine)
