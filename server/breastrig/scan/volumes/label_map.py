"""The skin and the lesions of a label map: NIfTI, or DICOM segmentation (SEG); with the extra `mri`.

A label map says for each voxel what is there, 0 for nothing.  The body is all that the air in front of it does not
reach, so labels may leave parts of it out (lungs, fat); where the field of view ends the skin ends, open.  Places are
in the DICOM patient frame (LPS: to the patient's left, back, head), in mm, as mesh files of 3D Slicer have them.
"""

import gzip
import importlib.util
import io
import warnings
import zlib

import numpy as np

from breastrig.core.errors import BadScan, BadSettings, TooLarge
from breastrig.scan.limits import GZIP_MEMBERS, LABEL_MAP_BYTES, MEBIBYTE
from breastrig.scan.piece import BallInside, Piece, Pieces, TakenSegment
from breastrig.scan.volumes.answers import VolumeAnswers
from breastrig.scan.volumes.body import Bodies, check_shows_body, filled, skin
from breastrig.scan.volumes.dicom_seg import read_segmentation
from breastrig.scan.volumes.nifti import read_nifti
from breastrig.scan.volumes.question import needs_answer
from breastrig.scan.volumes.segments import check_chosen, taken_segments

FRAME = "Places are in the DICOM patient frame (LPS), mm; the skin was made from the label map."
NEEDS = 'Label maps need "breastrig[mri]"; install it, or export the skin as PLY, STL or OBJ.'
GZIP_START = b"\x1f\x8b\x08"


def label_map_pieces(data: bytes, kind: str, answers: VolumeAnswers) -> Pieces:
    """The skin with `lesions` and `segments`; `kind` is nifti or dicom.

    Raises BadScan or TooLarge with a sentence, NeedsAnswer where a person has to say something, BadSettings for
    answers that do not fit this file.
    """
    if importlib.util.find_spec("nibabel" if kind == "nifti" else "pydicom") is None:
        raise BadScan(NEEDS)
    if kind == "dicom" and answers.frame is not None:
        raise BadSettings("A DICOM segmentation says itself where it lies; leave frame out.")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about headers that are not quite as their standard wants them
        volume = read_nifti(data, answers.frame) if kind == "nifti" else read_segmentation(data)
        check_chosen(volume, answers.segments)
        there = filled(volume, frozenset(number for number, what in answers.segments.items() if what == "unused"))
        check_shows_body(there, volume.readings[0].affine)
        bodies = Bodies(there)
        if len(volume.readings) > 1:
            raise needs_answer(volume, bodies, answers.segments)
        affine = volume.readings[0].affine
        body = bodies.body(affine)
        taken = taken_segments(volume, body, abs(float(np.linalg.det(affine[:3, :3]))), answers.segments)
        vertices, faces = skin(body, affine, volume.gaps)
    lesions = tuple(BallInside(each.name, (affine @ [*each.center, 1.0])[:3], each.radius) for each in taken.lesions)
    notes = (FRAME, *volume.notes, *map(_said, taken.segments))
    piece = Piece(vertices, faces)
    return Pieces((piece,), notes=notes, unit="mm", is_label_map=True, lesions=lesions, segments=taken.segments)


def _said(segment: TakenSegment) -> str:
    """What became of it, without the file's words."""
    across = "" if segment.radius_mm is None else f", {2 * segment.radius_mm:.0f} mm across"
    what = {"lesion": "taken for a lesion", "tissue": "taken for tissue", "unused": "left out"}[segment.taken_as]
    return f"Segment {segment.number} of the label map was {what} ({segment.name}{across}): {_lowered(segment.why)}"


def _lowered(sentence: str) -> str:
    return sentence[:1].lower() + sentence[1:]


def gunzipped(data: bytes) -> bytes:
    """What the members of a .gz hold, one after the other.

    TooLarge beyond the limit of label maps, BadScan where it is damaged.
    """
    if data.count(GZIP_START) > GZIP_MEMBERS:
        raise TooLarge("This .gz file is packed in far too many parts; pack it again.")
    try:
        whole = gzip.GzipFile(fileobj=io.BytesIO(data)).read(LABEL_MAP_BYTES + 1)
    except EOFError as error:
        raise BadScan("This .gz file is cut off; pack it again.") from error
    except (OSError, zlib.error) as error:
        raise BadScan("This .gz file is damaged; pack it again.") from error
    if len(whole) > LABEL_MAP_BYTES:
        raise TooLarge(f"This .gz file unpacks to more than the {LABEL_MAP_BYTES // MEBIBYTE} MB allowed.")
    return whole
