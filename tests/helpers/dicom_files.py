"""DICOM files of an MR image as scanners write them: a folder or zip of slices, or one file of many frames."""

import argparse
import io
import sys
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


def lesion_seg(series: Series, lesion: np.ndarray) -> bytes:
    """A segmentation of a lesion (I, J, K) on the slices of this series, as highdicom writes it."""
    from highdicom.seg import SegmentAlgorithmTypeValues, Segmentation, SegmentationTypeValues, SegmentDescription
    from pydicom.sr.codedict import codes

    sources = [file_dataset(each, series) for each in slices(series)]
    described = SegmentDescription(
        segment_number=1,
        segment_label="Index lesion",
        segmented_property_category=codes.SCT.MorphologicallyAbnormalStructure,
        segmented_property_type=codes.SCT.Mass,
        algorithm_type=SegmentAlgorithmTypeValues.MANUAL,
    )
    made = Segmentation(
        source_images=sources,
        pixel_array=np.ascontiguousarray(lesion.transpose(2, 1, 0)),
        segmentation_type=SegmentationTypeValues.BINARY,
        segment_descriptions=[described],
        series_instance_uid=uid(series.name, "seg"),
        series_number=99,
        sop_instance_uid=uid(series.name, "seg", 1),
        instance_number=1,
        manufacturer="BreastRig",
        manufacturer_model_name="tests",
        software_versions="1",
        device_serial_number="1",
    )
    stream = io.BytesIO()
    made.save_as(stream)
    return stream.getvalue()


def file_dataset(made: Dataset, series: Series) -> Dataset:
    """With what a segmentation wants of its sources."""
    made.StudyInstanceUID, made.StudyID, made.StudyTime = uid("study"), "1", "120000"
    made.AccessionNumber, made.ReferringPhysicianName, made.PatientSex = "", "", "F"
    made.file_meta = FileMetaDataset()
    made.file_meta.TransferSyntaxUID = series.syntax
    return made


def main(words: Sequence[str]) -> None:
    """Writes a zip of an MRI for tests of the page."""
    options = argparse.ArgumentParser(description=main.__doc__)
    options.add_argument("out", type=Path)
    options.add_argument("--series", type=int, default=1, help="so many")
    options.add_argument("--step", type=float, default=3.0, help="mm of a voxel")
    options.add_argument("--lesion", action="store_true", help="with a segmentation of the lesion")
    options.add_argument("--seg", type=Path, help="a file for that segmentation alone")
    options.add_argument("--enhanced", action="store_true", help="all slices in one file")
    options.add_argument("--seed", type=int, default=2, help="of the synthetic woman")
    chosen = options.parse_args(words)
    woman = mr_image(seed=chosen.seed, step=chosen.step)
    several = [Series(woman.image, f"t1 {number}", number) for number in range(1, chosen.series + 1)]
    content = files(*several, many_frames=chosen.enhanced)
    if chosen.lesion:
        content |= {"SEG": lesion_seg(several[0], woman.lesion)}
    if chosen.seg is not None:
        chosen.seg.write_bytes(lesion_seg(several[0], woman.lesion))
    chosen.out.write_bytes(zipped(content, zipfile.ZIP_DEFLATED))


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))
    from helpers.mr_image import mr_image

    main(sys.argv[1:])
