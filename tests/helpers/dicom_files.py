"""DICOM files of an MR image as scanners write them: a folder or zip of slices, or one file of many frames."""

import io
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.uid import UID, ExplicitVRLittleEndian, generate_uid

from breastrig.scan.images.image import ImageVolume

MR, ENHANCED = UID("1.2.840.10008.5.1.4.1.1.4"), UID("1.2.840.10008.5.1.4.1.1.4.1")
NAME = "Müßterfrau^Änne"  # stands in every file, and must stand in nothing that is kept
SECRET = "Geheim^Wort"


@dataclass(frozen=True)
class Series:
    """How an image is written."""

    image: ImageVolume
    name: str = "t1"  # makes the UIDs, and is the description
    number: int = 1
    left_out: Sequence[int] = ()  # slices
    change: Callable[[Dataset, int], None] = lambda made, at: None  # of each slice's header, last
    syntax: UID = ExplicitVRLittleEndian
    frame_of: str = "frame"
    preamble: bool = True
    extra: Mapping[str, bytes] = field(default_factory=dict)


def uid(*words: object) -> UID:
    """The same for the same words."""
    return generate_uid(entropy_srcs=[str(each) for each in words])


def slices(series: Series) -> list[Dataset]:
    """Classic files, one a slice, with names and dates of a patient who does not exist."""
    values, affine = series.image.values, series.image.affine
    sizes = np.linalg.norm(affine[:3, :3], axis=0)
    found = []
    for at in range(values.shape[2]):
        if at in series.left_out:
            continue
        made = _common(series, MR, at)
        made.InstanceNumber = at + 1
        made.ImagePositionPatient = [float(each) for each in affine[:3, 3] + at * affine[:3, 2]]
        made.ImageOrientationPatient = [float(each) for each in (affine[:3, :2] / sizes[:2]).T.ravel()]
        made.PixelSpacing = [float(sizes[1]), float(sizes[0])]
        made.SliceThickness = float(sizes[2])
        _pixels(made, values[:, :, at].T)
        series.change(made, at)
        found.append(made)
    return found


def enhanced(series: Series) -> Dataset:
    """All slices as frames of one file."""
    values, affine = series.image.values, series.image.affine
    sizes = np.linalg.norm(affine[:3, :3], axis=0)
    made = _common(series, ENHANCED, 0)
    shown = [at for at in range(values.shape[2]) if at not in series.left_out]
    made.NumberOfFrames = len(shown)
    _pixels(made, np.stack([values[:, :, at].T for at in shown]))
    shared, measures, plane = Dataset(), Dataset(), Dataset()
    measures.PixelSpacing, measures.SliceThickness = [float(sizes[1]), float(sizes[0])], float(sizes[2])
    plane.ImageOrientationPatient = [float(each) for each in (affine[:3, :2] / sizes[:2]).T.ravel()]
    shared.PixelMeasuresSequence, shared.PlaneOrientationSequence = [measures], [plane]
    made.SharedFunctionalGroupsSequence = [shared]
    own = []
    for at in shown:
        groups, position, content = Dataset(), Dataset(), Dataset()
        position.ImagePositionPatient = [float(each) for each in affine[:3, 3] + at * affine[:3, 2]]
        content.StackID, content.InStackPositionNumber, content.FrameComments = "1", at + 1, SECRET
        groups.PlanePositionSequence, groups.FrameContentSequence = [position], [content]
        own.append(groups)
    made.PerFrameFunctionalGroupsSequence = own
    series.change(made, 0)
    return made


def _common(series: Series, kind: UID, at: int) -> Dataset:
    made = Dataset()
    made.SpecificCharacterSet = "ISO_IR 192"
    made.SOPClassUID, made.SOPInstanceUID = kind, uid(series.name, kind, at)
    made.Modality, made.ImageType = "MR", ["ORIGINAL", "PRIMARY", "M"]
    made.PatientName, made.PatientID, made.PatientBirthDate = NAME, SECRET, "19700101"
    made.InstitutionName, made.StudyDate = SECRET, "20260102"
    made.SeriesDescription, made.SeriesNumber = series.name, series.number
    made.SeriesInstanceUID, made.FrameOfReferenceUID = uid(series.name, "series"), uid(series.frame_of)
    made.SamplesPerPixel, made.PhotometricInterpretation = 1, "MONOCHROME2"
    return made


def _pixels(made: Dataset, values: np.ndarray) -> None:
    """(..., R, C) whole numbers."""
    made.Rows, made.Columns = values.shape[-2:]
    made.BitsAllocated = made.BitsStored = 8 * values.dtype.itemsize
    made.HighBit, made.PixelRepresentation = made.BitsStored - 1, int(values.dtype.kind == "i")
    made.add_new(0x7FE00010, "OW", np.ascontiguousarray(values).astype(values.dtype.newbyteorder("<")).tobytes())


def file_of(made: Dataset, syntax: UID = ExplicitVRLittleEndian, preamble: bool = True) -> bytes:
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID = made.SOPClassUID, made.SOPInstanceUID
    meta.TransferSyntaxUID = syntax
    made.file_meta = meta
    stream = io.BytesIO()
    made.save_as(stream, enforce_file_format=preamble)
    return stream.getvalue()


def files(*several: Series, many_frames: bool = False) -> dict[str, bytes]:
    """Name -> content, with names as on hospitals' media: they say nothing, and their order means nothing."""
    found: list[bytes] = []
    for series in several:
        made = [enhanced(series)] if many_frames else slices(series)
        found += [file_of(each, series.syntax, series.preamble) for each in made]
    order = np.random.default_rng(0).permutation(len(found))
    names = {f"DICOM/Änne/S{at // 100:03d}/I{at:05d}": found[which] for at, which in enumerate(order)}
    return names | {name: content for series in several for name, content in series.extra.items()}


def zipped(content: Mapping[str, bytes], packing: int = zipfile.ZIP_STORED) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", packing) as archive:
        for name, data in content.items():
            archive.writestr(name, data)
    return stream.getvalue()


def foldered(content: Mapping[str, bytes], folder: Path) -> Path:
    for name, data in content.items():
        place = folder / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(data)
    return folder
