"""Lesions of another file than the scan's, drawn on the image that it was made of: untrusted bytes, as a scan's."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from breastrig.core.errors import BadInput, BadScan, NeedsAnswer
from breastrig.scan.images.added_lesions import NO_IMAGE, LesionsRead, taken
from breastrig.scan.kept_image import KeptImage
from breastrig.scan.piece import BallInside, Pieces
from breastrig.scan.scan import Scan
from breastrig.scan.untrusted import bytes_of, guarded
from breastrig.scan.volumes.answers import VolumeAnswers

LEFT_OUT = "A segmentation beside the image was left out: {}"


def lesions_in(source: Path | bytes, on: KeptImage | None, answers: VolumeAnswers) -> LesionsRead:
    """The lesions of a file that lie in the image, mm.

    Raises BadScan or TooLarge with a sentence, of BadScan NeedsAnswer, where a person has to say something, and
    BadSettings for answers that do not fit the file.
    """
    if on is None:
        raise BadScan(NO_IMAGE)
    from breastrig.scan.images.lesion_files import lesions_of  # SciPy's filters, and few scans are volumes

    return guarded("segmentation", partial(lesions_of, bytes_of(source), on, answers))


def with_lesions(scan: Scan, sources: Sequence[Path | bytes], answers: VolumeAnswers) -> Scan:
    """The scan of an image with the lesions of these files.  Raises as `lesions_in`."""
    for source in sources:
        found = lesions_in(source, scan.image, answers)
        known = [_scaled(each, 1e3) for each in scan.lesions]
        named = taken(found.lesions, found.segments, found.notes, known)
        scan = replace(
            scan,
            lesions=(*scan.lesions, *(_scaled(each, 1e-3) for each in named.lesions if each.is_new)),
            segments=(*scan.segments, *named.segments),
            wall=scan.wall if found.wall is None else (1e-3 * found.wall[0], found.wall[1]),
            notes=(*scan.notes, *named.notes),
        )
    return scan


def with_lesions_beside(image: Pieces, files: Sequence[bytes], answers: VolumeAnswers) -> Pieces:
    """The image with the lesions of files that lay beside it; what cannot be read of them is left out and said.

    Raises NeedsAnswer.
    """
    for file in files:
        try:
            found = lesions_in(file, image.image, answers)
        except NeedsAnswer:
            raise
        except BadInput as error:
            image = replace(image, notes=(*image.notes, LEFT_OUT.format(error)))
            continue
        named = taken(found.lesions, found.segments, found.notes, image.lesions)
        new = (each for each in named.lesions if each.is_new)
        image = replace(
            image,
            lesions=(*image.lesions, *new),
            notes=(*image.notes, *named.notes),
            wall=found.wall or image.wall,
        )
    return image


def _scaled(lesion: BallInside, factor: float) -> BallInside:
    return BallInside(lesion.name, factor * lesion.center, factor * lesion.radius)
