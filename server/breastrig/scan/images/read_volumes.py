"""The contents of volumes: label maps and images, alone or as a folder or zip of DICOM files."""

from pathlib import Path

from breastrig.core.errors import BadSettings, unknown_name
from breastrig.core.units import UNIT_CHOICES
from breastrig.scan.images.dicom_images import NO_SERIES, DicomImage, image_in, image_of_file
from breastrig.scan.piece import Pieces
from breastrig.scan.volumes.answers import VolumeAnswers


def pieces_in(source: Path | bytes, units: str, answers: VolumeAnswers) -> Pieces | bytes | None:
    """The MRI in a folder or zip; the bytes of a folder's one label map; None for every other file.

    Raises BadScan or TooLarge with a sentence, NeedsAnswer, BadSettings.
    """
    found = image_in(source, answers)
    if not isinstance(found, DicomImage):
        return found
    from breastrig.scan.images.image_pieces import image_pieces  # SciPy's filters, and few scans are volumes
    from breastrig.scan.images.read_lesions import with_lesions_beside

    _check_unit(units)
    return with_lesions_beside(image_pieces(found.image), found.segmentations, answers)


def pieces_of(data: bytes, kind: str, units: str, answers: VolumeAnswers) -> Pieces:
    """The contents of one file, in mm.  Raises as `pieces_in`."""
    from breastrig.scan.images.grid_image import image_of
    from breastrig.scan.images.image_pieces import image_pieces
    from breastrig.scan.volumes.grids.grid import Grid
    from breastrig.scan.volumes.label_map import label_map_pieces
    from breastrig.scan.volumes.volume_files import read_volume

    _check_unit(units)
    if kind == "dicom" and (image := image_of_file(data, answers)) is not None:
        return image_pieces(image)
    if answers.series is not None:
        raise BadSettings(NO_SERIES)
    found = read_volume(data, kind, answers.frame)
    if not isinstance(found, Grid):
        return label_map_pieces(found, answers)
    if answers.segments:
        raise BadSettings("This is an image, which has no segments; leave segments out.")
    return image_pieces(image_of(found))


def _check_unit(units: str) -> None:
    if units not in UNIT_CHOICES:
        raise BadSettings(unknown_name("unit", units, UNIT_CHOICES))
    if units not in ("auto", "mm"):
        raise BadSettings("A label map or an MRI has a unit of its own, and is read in mm; leave units out.")
