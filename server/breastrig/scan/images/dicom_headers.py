"""What places the pixels of a DICOM image, and how the patient lies; nothing else of its header is read: no names."""

import io
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from breastrig.core.errors import BadInput, BadScan, TooLarge
from breastrig.core.stances import Stance
from breastrig.scan.file_type import DICOM_MARK_AT, SEGMENTATIONS, STRUCTURES
from breastrig.scan.images.dicom_files import DicomFile
from breastrig.scan.limits import DICOM_ELEMENTS, DICOM_FRAMES, DICOM_HEAD_BYTES, DICOM_ITEMS, IMAGE_SIDE
from breastrig.scan.volumes.dicom_seg import DAMAGED, DEFLATED, ITEM, plain_dicom
from breastrig.scan.volumes.unlogged import unlogged

FIRST = 256 * 1024  # bytes that hold the header of most files
PIXELS = 0x7FE00000  # the group of tags with which the header ends
UNKNOWN_LENGTH = 0xFFFFFFFF
TAGS = (
    "SOPClassUID",
    "SOPInstanceUID",
    "Modality",
    "ImageType",
    "SpecificCharacterSet",
    "SeriesDescription",
    "SeriesInstanceUID",
    "SeriesNumber",
    "FrameOfReferenceUID",
    "PatientPosition",
    "ImagePositionPatient",
    "ImageOrientationPatient",
    "PixelSpacing",
    "Rows",
    "Columns",
    "NumberOfFrames",
    "SamplesPerPixel",
    "BitsAllocated",
    "PhotometricInterpretation",
    "RescaleSlope",
    "RescaleIntercept",
    "TemporalPositionIdentifier",
    "EchoNumbers",
    "EchoTime",
    "DiffusionBValue",
    "AcquisitionNumber",
    "TriggerTime",
    "SharedFunctionalGroupsSequence",
    "PerFrameFunctionalGroupsSequence",
)
NO_PLACE = "These DICOM images do not say where they lie in the patient; give the MR images themselves."
LIES: dict[str, Stance] = {"HFP": "prone", "FFP": "prone", "HFS": "supine", "FFS": "supine"}  # head or feet first
GREY = ("MONOCHROME1", "MONOCHROME2")


@dataclass(frozen=True, eq=False)
class Slice:
    """One picture: a whole file, or a frame of one."""

    file: DicomFile
    frame: int
    frames: int  # of the file
    instance: str  # digest-like name of the file, to tell copies
    series: str  # UID
    number: int  # of the series, for the order of what is shown
    words: str = ""  # of the header about the series: shown while choosing, and never kept
    reference: str = ""  # UID of the frame of reference
    stance: Stance | None = None  # in which the patient lies
    rows: int = 0
    columns: int = 0
    spacing: tuple[float, ...] = ()  # mm between rows, and between columns
    turn: tuple[float, ...] = ()  # direction cosines of a row and a column
    place: tuple[float, ...] = ()  # mm, LPS, of the first pixel
    slope: float = 1.0
    intercept: float = 0.0
    is_inverted: bool = False  # larger is darker
    kind: tuple[str, ...] = ()  # original or derived, axial or localizer, magnitude or phase, ...
    varied: tuple[float, ...] = ()  # what makes two pictures of one place: each a volume of its own
    perhaps: tuple[float, ...] = ()  # what may, where several lie on one place


@dataclass(frozen=True, eq=False)
class Header:
    """What a file is."""

    content: str  # image, segmentation, structures, or other
    modality: str = ""
    series: str = ""
    slices: tuple[Slice, ...] = ()
    fault: str = ""  # one sentence: why an image has no slices


def header_of(file: DicomFile) -> Header:
    """BadScan where the file is damaged, TooLarge where its header is over a limit."""
    try:
        with unlogged():
            dataset, pixels = _parsed(file)
            return _header(file, dataset, pixels)
    except BadInput:
        raise
    except Exception as error:  # it can raise anything
        raise BadScan(DAMAGED) from error


def _parsed(file: DicomFile) -> tuple[Any, int | None]:
    """The header, and the bytes that a file with such pixels has: 0 where that is not said, None without pixels."""
    data = file.read(FIRST)
    if len(data) < file.size:
        try:
            dataset, pixels = _read(data)
        except BadInput:
            raise
        except Exception:  # cut off within a value
            pixels = None
        if pixels is not None:
            return dataset, pixels
        data = file.whole()
    return _read(data)


def _read(data: bytes) -> tuple[Any, int | None]:
    from pydicom.datadict import tag_for_keyword
    from pydicom.filereader import read_partial

    is_packed, data = DEFLATED in data, plain_dicom(data)
    if data.count(ITEM, 0, DICOM_HEAD_BYTES) > DICOM_ITEMS:
        raise TooLarge(f"This DICOM file has more than the {DICOM_ITEMS:,} entries allowed; export fewer frames.")
    seen, pixels = 0, None

    def stop(tag: int, _: str | None, length: int) -> bool:
        nonlocal seen, pixels
        seen += 1
        if seen > DICOM_ELEMENTS:
            raise TooLarge(f"This DICOM file has more than the {DICOM_ELEMENTS:,} elements allowed; export it again.")
        if tag >= PIXELS:
            pixels = 0 if length == UNKNOWN_LENGTH or is_packed else length
            return True
        return stream.tell() > DICOM_HEAD_BYTES

    stream = io.BytesIO(data)
    tags = [tag_for_keyword(name) for name in TAGS]
    dataset = read_partial(stream, stop, force=True, specific_tags=[tag for tag in tags if tag is not None])
    return dataset, pixels and stream.tell() + pixels


def _header(file: DicomFile, dataset: Any, pixels: int | None) -> Header:
    kind, modality = str(dataset.get("SOPClassUID", "")), str(dataset.get("Modality", ""))
    series = str(dataset.get("SeriesInstanceUID", ""))
    if kind in SEGMENTATIONS or modality == "SEG":
        return Header("segmentation", modality, series)
    if kind == STRUCTURES or modality == "RTSTRUCT":
        return Header("structures", modality, series)
    if pixels is None or "Rows" not in dataset:
        return Header("other", modality, series)
    if pixels > file.size + DICOM_MARK_AT:
        raise BadScan(DAMAGED)
    if modality != "MR":
        shown = modality if modality.isalnum() and len(modality) <= 16 else "not named"
        fault = f"These DICOM images are no MR images (their modality is {shown}); give the MRI."
        return Header("image", modality, series, (), fault)
    if int(dataset.get("SamplesPerPixel", 1)) != 1 or str(dataset.get("PhotometricInterpretation", "")) not in GREY:
        return Header("image", modality, series, (), "These DICOM images are in colour; give the MR images themselves.")
    rows, columns = int(dataset.Rows), int(dataset.Columns)
    if not (0 < rows <= IMAGE_SIDE and 0 < columns <= IMAGE_SIDE):
        raise TooLarge(f"A DICOM image has {rows} x {columns} pixels; at most {IMAGE_SIDE} x {IMAGE_SIDE} are read.")
    slices = tuple(_slices(file, dataset, series, rows, columns))
    fault = "" if slices else NO_PLACE
    return Header("image", modality, series, slices, fault)


def _slices(file: DicomFile, dataset: Any, series: str, rows: int, columns: int) -> Iterator[Slice]:
    """The pictures that say where they lie."""
    frames = int(dataset.get("NumberOfFrames", None) or 1)
    own: Any = list(dataset.get("PerFrameFunctionalGroupsSequence", None) or [])
    if frames > DICOM_FRAMES:
        raise TooLarge(f"A DICOM file has {frames:,} frames, more than the {DICOM_FRAMES:,} allowed.")
    if frames > 1 and len(own) < frames:
        return
    shared: Any = next(iter(dataset.get("SharedFunctionalGroupsSequence", None) or []), {})
    instance, number = str(dataset.get("SOPInstanceUID", "")), dataset.get("SeriesNumber", None)
    for frame in range(frames):
        groups: list[Any] = [own[frame], shared] if own else []

        def said(name: str, group: str = "", groups: list[Any] = groups) -> Any:
            for each in groups if group else ():
                item: Any = next(iter(each.get(group, None) or []), {})
                if (value := item.get(name, None)) is not None:
                    return value
            return dataset.get(name, None)

        spacing = _numbers(said("PixelSpacing", "PixelMeasuresSequence"), 2)
        turn = _numbers(said("ImageOrientationPatient", "PlaneOrientationSequence"), 6)
        place = _numbers(said("ImagePositionPatient", "PlanePositionSequence"), 3)
        if not (spacing and turn and place):
            continue
        kind = said("FrameType", "MRImageFrameTypeSequence") or dataset.get("ImageType", None) or ()
        slope = _number(said("RescaleSlope", "PixelValueTransformationSequence"))
        intercept = _number(said("RescaleIntercept", "PixelValueTransformationSequence"))
        echo = said("EffectiveEchoTime", "MREchoSequence")
        phase = said("TemporalPositionIndex", "FrameContentSequence")
        acquired = said("FrameAcquisitionNumber", "FrameContentSequence")
        trigger = said("NominalCardiacTriggerDelayTime", "CardiacSynchronizationSequence")
        yield Slice(
            file=file,
            frame=frame,
            frames=frames,
            instance=instance,
            series=series,
            number=int(_number(number) or 0),
            words=str(dataset.get("SeriesDescription", "") or ""),
            reference=str(dataset.get("FrameOfReferenceUID", "") or ""),
            stance=LIES.get(str(dataset.get("PatientPosition", ""))),
            rows=rows,
            columns=columns,
            spacing=spacing,
            turn=turn,
            place=place,
            slope=1.0 if slope is None else slope,
            intercept=intercept or 0.0,
            is_inverted=str(dataset.PhotometricInterpretation) == "MONOCHROME1",
            kind=(kind,) if isinstance(kind, str) else tuple(str(each) for each in kind),
            varied=tuple(
                _number(each) or 0.0
                for each in (
                    phase if phase is not None else dataset.get("TemporalPositionIdentifier", None),
                    said("DiffusionBValue", "MRDiffusionSequence"),
                    echo if echo is not None else dataset.get("EchoTime", None),
                )
            ),
            perhaps=tuple(
                _number(each) or 0.0
                for each in (
                    acquired if acquired is not None else dataset.get("AcquisitionNumber", None),
                    trigger if trigger is not None else dataset.get("TriggerTime", None),
                )
            ),
        )


def _numbers(value: Any, size: int) -> tuple[float, ...]:
    """So many finite numbers; empty where they are not."""
    try:
        found = np.asarray(value, np.float64).reshape(-1)
    except (TypeError, ValueError):
        return ()
    return tuple(found.tolist()) if found.shape == (size,) and np.isfinite(found).all() else ()


def _number(value: Any) -> float | None:
    found = _numbers(value, 1)
    return found[0] if found else None
