"""The MR image that the files of a folder or zip hold; where they hold several series a person says which."""

import importlib.util
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from breastrig.core.errors import BadInput, BadScan, BadSettings
from breastrig.scan.file_type import file_type_of
from breastrig.scan.images.dicom_files import DicomFile, dicom_files, one_file
from breastrig.scan.images.dicom_headers import Header, header_of
from breastrig.scan.images.dicom_pixels import volume_of
from breastrig.scan.images.dicom_series import TOO_FEW, Found, stacks_of
from breastrig.scan.images.image import ImageVolume
from breastrig.scan.images.series_question import which_series
from breastrig.scan.untrusted import guarded
from breastrig.scan.volumes.answers import VolumeAnswers
from breastrig.scan.volumes.grids.grid import Grid
from breastrig.scan.volumes.gzipped import GZIP_START, gunzipped
from breastrig.scan.volumes.volume_files import read_volume

NEEDS = 'DICOM images need "breastrig[mri]"; install it, or export the skin as PLY, STL or OBJ.'
NO_DICOM = "This folder holds no DICOM files; give the folder of an MRI, or a scan's own file."
NO_IMAGE = "This folder holds no MR image and no DICOM segmentation; give the folder of an MRI."
SEVERAL_MAPS = "This folder holds several DICOM segmentations and no MR image; give the file of the one that is meant."
BESIDE = ("segmentation", "structures")
SEGMENTATIONS = 20  # files beside an image

NO_SERIES = "This file is no DICOM image; series is for those alone."
OTHER_ANSWERS = "A DICOM image says itself where it lies, and has no segments; leave frame and segments out."
LEFT_OUT = "{count} of the DICOM series there cannot be read and {were} left out: {why}"
DAMAGED_FILES = "{count} of the DICOM files there {are} damaged or cut off and {were} left out."


@dataclass(frozen=True, eq=False)
class DicomImage:
    """The image, and the segmentations that lie beside it."""

    image: ImageVolume
    segmentations: tuple[bytes, ...]  # whole files: SEG, RTSTRUCT, and volumes of other formats


def image_in(source: Path | bytes, answers: VolumeAnswers) -> DicomImage | bytes | None:
    """The image in a folder or zip of DICOM files; the bytes of a folder's one segmentation where there is no image.

    None for every other file.  Raises BadScan or TooLarge with a sentence, NeedsAnswer where there are several series,
    BadSettings for answers that do not fit.
    """
    with dicom_files(source) as volumes:
        is_folder = isinstance(source, Path) and source.is_dir()
        files, grids = ([each for each in volumes if each.is_grid is which] for which in (False, True))
        if not files:
            if (image := _image_among(grids, [], answers)) is not None:
                return image
            if is_folder:
                raise BadScan(NO_DICOM)
            return None
        if importlib.util.find_spec("pydicom") is None:
            raise BadScan(NEEDS)
        headers, damaged = _headers(files)
        beside = [file for file, header in headers if header.content in BESIDE]
        found = _found(headers)
        if not found.stacks and (beside or not any(header.content == "image" for _, header in headers)):
            if (image := _image_among(grids, beside, answers)) is not None:
                return image
            if not is_folder:
                return None  # a label map, or what is refused as such
            maps = [file for file, header in headers if header.content == "segmentation"]
            if len(maps) != 1:
                raise BadScan(NO_IMAGE if not maps else SEVERAL_MAPS)
            return maps[0].whole()
        beside += grids
        chosen = _image(found, damaged, answers.without_lesions if beside else answers)
        return DicomImage(chosen, tuple(file.whole() for file in beside[:SEGMENTATIONS]))


def image_of_file(data: bytes, answers: VolumeAnswers) -> ImageVolume | None:
    """The image of one file of many frames; None where it holds a segmentation or none of both.

    Raises as `image_in`.
    """
    if importlib.util.find_spec("pydicom") is None:
        raise BadScan(NEEDS)
    file = one_file(data)
    header = header_of(file)
    return _image(_found([(file, header)]), 0, answers) if header.content == "image" else None


def _image_among(grids: Sequence[DicomFile], beside: Sequence[DicomFile], answers: VolumeAnswers) -> DicomImage | None:
    """The one image among volumes of other formats, with all else as its segmentations; None for another number."""
    if not grids or len(grids) + len(beside) < 2:
        return None
    from breastrig.scan.images.grid_image import image_of  # SciPy's filters, and few scans are volumes

    image, others = None, []
    for file in grids[: SEGMENTATIONS + 1]:
        whole = file.whole()
        try:
            grid = guarded("volume", partial(_grid, whole, answers))
        except BadInput:
            grid = None  # is left out with the reason
        if grid is None:
            others.append(whole)
        elif image is not None:
            return None
        else:
            image = grid
    if image is None:
        return None
    if answers.series is not None:
        raise BadSettings(NO_SERIES)
    return DicomImage(image_of(image), tuple([*others, *(each.whole() for each in beside)][:SEGMENTATIONS]))


def _grid(data: bytes, answers: VolumeAnswers) -> Grid | None:
    """None for a label map."""
    data = gunzipped(data) if data.startswith(GZIP_START) else data
    found = read_volume(data, file_type_of(data), answers.frame)
    return found if isinstance(found, Grid) else None


def _headers(files: Sequence[DicomFile]) -> tuple[list[tuple[DicomFile, Header]], int]:
    """Of the files that can be read, and how many cannot."""
    found, damaged = [], 0
    for file in files:
        try:
            found.append((file, header_of(file)))
        except BadScan:
            damaged += 1
    return found, damaged


def _found(headers: Sequence[tuple[DicomFile, Header]]) -> Found:
    found = stacks_of(each for _, header in headers for each in header.slices)
    found.faults += [BadScan(fault) for fault in dict.fromkeys(header.fault for _, header in headers) if fault]
    return found


def _image(found: Found, damaged: int, answers: VolumeAnswers) -> ImageVolume:
    """The chosen stack's voxels."""
    if answers.frame is not None or answers.segments:
        raise BadSettings(OTHER_ANSWERS)
    stacks = {each.value: each for each in found.stacks}
    if not stacks:
        raise found.faults[0] if found.faults else BadScan(TOO_FEW)
    if answers.series is not None and answers.series not in stacks:
        known = ", ".join(stacks)
        raise BadSettings(f"There is no such series in these DICOM files; they have {known}.")
    if answers.series is None and len(stacks) > 1:
        raise which_series(found.stacks)
    image = volume_of(stacks[answers.series or found.stacks[0].value])
    notes = []
    if damaged:
        are, were = ("is", "was") if damaged == 1 else ("are", "were")
        notes.append(DAMAGED_FILES.format(count=damaged, are=are, were=were))
    if found.faults:
        count = len(found.faults)
        notes.append(LEFT_OUT.format(count=count, were="was" if count == 1 else "were", why=found.faults[0]))
    return replace(image, notes=(*image.notes, *notes))
