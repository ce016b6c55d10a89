"""The skin and the lesions of a label map.

A label map says for each voxel what is there, 0 for nothing.  The body is all that the air in front of it does not
reach, so labels may leave parts of it out (lungs, fat); where the field of view ends the skin ends, open.  Places are
in the DICOM patient frame (LPS: to the patient's left, back, head), in mm, as mesh files of 3D Slicer have them.
"""

from breastrig.scan.piece import BallInside, Piece, Pieces, TakenSegment
from breastrig.scan.volumes.answers import VolumeAnswers
from breastrig.scan.volumes.body import Bodies, check_shows_body, filled, skin
from breastrig.scan.volumes.question import needs_answer
from breastrig.scan.volumes.segments import check_chosen, taken_segments
from breastrig.scan.volumes.unlogged import unlogged
from breastrig.scan.volumes.volume import Volume
from breastrig.scan.volumes.wall import SEEN, wall_of

FRAME = "Places are in the DICOM patient frame (LPS), mm; the skin was made from the label map."
BOTH = 200.0  # mm from right to left; nipples alone are 150 to 210 apart in the four given patients
ONE_BREAST = (
    "The skin is {:.0f} mm wide from right to left, as one breast alone: a fit finds no sure place on it; export both "
    "breasts and the skin between them."
)
SAID_EACH = 12  # segments, each with a sentence of its own


def label_map_pieces(volume: Volume, answers: VolumeAnswers) -> Pieces:
    """The skin with `lesions` and `segments`.

    Raises BadScan or TooLarge with a sentence, NeedsAnswer where a person has to say something, BadSettings for
    answers that do not fit this volume.
    """
    with unlogged():  # bodies that are not quite as libraries want them
        check_chosen(volume, answers.segments)
        there = filled(volume, frozenset(number for number, what in answers.segments.items() if what == "unused"))
        check_shows_body(there, volume.readings[0].affine)
        bodies = Bodies(there)
        if len(volume.readings) > 1:
            raise needs_answer(volume, bodies, answers.segments)
        affine = volume.readings[0].affine
        body = bodies.body(affine)
        taken = taken_segments(volume, body.__getitem__, affine, answers.segments)
        vertices, faces = skin(body, affine, volume.gaps)
        wall = wall_of(volume, taken.segments, affine)
    lesions = tuple(BallInside(each.name, (affine @ [*each.center, 1.0])[:3], each.radius) for each in taken.lesions)
    width = float(vertices[:, 0].max() - vertices[:, 0].min()) if len(vertices) else BOTH
    narrow = (ONE_BREAST.format(width),) if width < BOTH else ()
    notes = (FRAME, *narrow, *volume.notes, *said_of(taken.segments), *([] if wall is None else [SEEN]))
    piece = Piece(vertices, faces)
    return Pieces(
        (piece,), notes=notes, unit="mm", is_label_map=True, lesions=lesions, segments=taken.segments, wall=wall
    )


def said_of(segments: tuple[TakenSegment, ...]) -> list[str]:
    """Notes on the use of each segment, without the file's words; many tissue segments are only counted."""
    named = [each for each in segments if len(segments) <= SAID_EACH or each.taken_as != "tissue"]
    notes = []
    for each in named:
        across = "" if each.radius_mm is None else f", {2 * each.radius_mm:.0f} mm across"
        what = {"lesion": "taken for a lesion", "tissue": "taken for tissue", "unused": "left out"}[each.taken_as]
        notes.append(f"Segment {each.number} of the file was {what} ({each.name}{across}). {each.why}")
    if len(named) < len(segments):
        notes.append(f"{'The other' if named else 'All'} {len(segments) - len(named)} segments were taken for tissue.")
    return notes
