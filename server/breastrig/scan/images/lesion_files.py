"""Lesions of a file of their own (label map, SEG or RTSTRUCT), drawn on an image that is there already."""

from breastrig.core.errors import BadScan
from breastrig.scan.file_type import VOLUMES, file_type_of
from breastrig.scan.formats.archive import unpacked
from breastrig.scan.images.added_lesions import LesionsRead
from breastrig.scan.images.same_place import (
    OTHER_FRAME,
    SHIFTED,
    doubt_of_place,
    same_place_question,
    shift_of,
    tissue_of,
)
from breastrig.scan.kept_image import KeptImage
from breastrig.scan.piece import BallInside
from breastrig.scan.volumes.answers import FORMS, VolumeAnswers
from breastrig.scan.volumes.body import Bodies, filled
from breastrig.scan.volumes.dicom_seg import AN_IMAGE
from breastrig.scan.volumes.grids.grid import Grid
from breastrig.scan.volumes.gzipped import GZIP_START, gunzipped
from breastrig.scan.volumes.label_map import said_of
from breastrig.scan.volumes.question import needs_answer
from breastrig.scan.volumes.segments import LESIONS, check_chosen, taken_segments
from breastrig.scan.volumes.unlogged import unlogged
from breastrig.scan.volumes.volume import Volume
from breastrig.scan.volumes.volume_files import read_volume
from breastrig.scan.volumes.wall import SEEN, wall_of

NO_SEGMENTATION = "This file holds no lesions; give a segmentation (NIfTI, NRRD, MetaImage, DICOM SEG, RTSTRUCT)."
NO_LESION = "No segment of this file was taken for a lesion; say which is one, such as 2=lesion."
SMALLER = "{} smaller parts of these lesions were left out; the {} largest were taken."
UNPLACED = (
    "This file does not say where its voxels lie, so its lesions cannot be placed in the image; save it with that."
)
ELSEWHERE = (
    "A person said that these lesions do not lie where the image does; export them from the series that was given."
)
SAID = "A person said that these lesions lie where the image does: {}."
ASSUMED = "That these lesions lie in the image's frame was assumed from their place; not both files name it."


def lesions_of(data: bytes, on: KeptImage, answers: VolumeAnswers) -> LesionsRead:
    """The lesions of a file in the frame of the image that they were drawn on.

    Raises BadScan or TooLarge with a sentence, NeedsAnswer (`same_place`, `frame`) where a person has to say
    something, BadSettings for answers that do not fit this file; a damaged file may raise anything.
    """
    data = gunzipped(data) if data.startswith(GZIP_START) else data
    kind = file_type_of(data)
    if kind == "zip":
        data = unpacked(data).mesh
        kind = file_type_of(data)
    if kind not in VOLUMES:
        raise BadScan(NO_SEGMENTATION)
    with unlogged():
        volume = read_volume(data, kind, answers.frame, with_contours=True)
        if isinstance(volume, Grid):
            raise BadScan(AN_IMAGE)
        check_chosen(volume, answers.segments)
        _check_frame(volume, answers)
        affine = volume.readings[0].affine
        tissue = tissue_of(on)
        taken = taken_segments(volume, tissue.on(affine), affine, answers.segments, are_lesions_alone=True)
    least = min(sorted((each.radius for each in taken.lesions), reverse=True)[:LESIONS], default=0.0)
    kept = [each for each in taken.lesions if each.radius >= least][:LESIONS]
    lesions = tuple(BallInside(each.name, (affine @ [*each.center, 1.0])[:3], each.radius) for each in kept)
    notes = (*volume.notes, *said_of(taken.segments))
    if len(kept) < len(taken.lesions):
        notes += (SMALLER.format(len(taken.lesions) - len(kept), LESIONS),)
    is_same = bool(on.frame) and volume.frame == on.frame
    wall = wall_of(volume, taken.segments, affine) if lesions or is_same else None
    notes += () if wall is None else (SEEN,)
    if not lesions:
        return LesionsRead((), taken.segments, (*notes, NO_LESION), wall)
    moved = shift_of(affine, volume.shape, on)
    doubt = doubt_of_place(lesions, tissue)
    if on.frame and volume.frame and not is_same:
        doubt = (OTHER_FRAME, lesions[0])
    elif moved and not is_same:
        doubt = (SHIFTED.format(moved), lesions[0])
    if answers.same_place is False:
        raise BadScan(ELSEWHERE)
    if doubt is not None:
        if answers.same_place is None:
            raise same_place_question(*doubt, on)
        notes += (SAID.format(doubt[0][:1].lower() + doubt[0][1:]),)
    elif not is_same:
        notes += (ASSUMED,)
    return LesionsRead(lesions, taken.segments, notes, wall)


def _check_frame(volume: Volume, answers: VolumeAnswers) -> None:
    """Raises BadScan where the voxels have no place, NeedsAnswer where they have two."""
    if len(volume.readings) > 1 and all(each.value in FORMS for each in volume.readings):
        raise needs_answer(volume, Bodies(filled(volume)), answers.segments)
    if len(volume.readings) > 1 or not volume.readings[0].is_placed:
        raise BadScan(UNPLACED)
