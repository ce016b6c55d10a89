"""DICOM structure sets (RTSTRUCT) of contours, with what a reader needs and hardly anything else."""

import io
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.uid import ExplicitVRLittleEndian, generate_uid


@dataclass(frozen=True)
class Region:
    """An ROI: its contours (N, 3) mm, LPS."""

    contours: list[np.ndarray] = field(default_factory=list)
    name: str = "ROI"
    kind: str = ""  # interpreted type


def circle(centre: np.ndarray, radius: float, points: int = 60) -> np.ndarray:
    """(N, 3) within an axial plane."""
    turn = np.linspace(0.0, 2.0 * np.pi, points, endpoint=False)
    return np.asarray(centre + radius * np.column_stack([np.cos(turn), np.sin(turn), np.zeros(points)]))


def ball(centre: np.ndarray, radius: float, step: float = 2.0, name: str = "ROI", kind: str = "") -> Region:
    """Contours in axial planes, `step` mm apart."""
    first = step * np.ceil((centre[2] - radius) / step)
    planes = np.arange(first, centre[2] + radius, step)
    radii = np.sqrt(np.maximum(radius**2 - (planes - centre[2]) ** 2, 0.0))
    found = [
        circle(np.array([centre[0], centre[1], at]), one) for at, one in zip(planes, radii, strict=True) if one > 0.2
    ]
    return Region(found, name, kind)


def structure_set(regions: Sequence[Region], frame: str | None = None) -> Dataset:
    made, place = Dataset(), Dataset()
    made.SOPClassUID, made.Modality = "1.2.840.10008.5.1.4.1.1.481.3", "RTSTRUCT"
    made.SpecificCharacterSet = "ISO_IR 192"
    place.FrameOfReferenceUID = frame or generate_uid(entropy_srcs=["frame"])
    made.ReferencedFrameOfReferenceSequence = [place]
    made.StructureSetROISequence, made.ROIContourSequence, made.RTROIObservationsSequence = [], [], []
    for number, region in enumerate(regions, 1):
        named, drawn, seen = Dataset(), Dataset(), Dataset()
        named.ROINumber, named.ROIName = number, region.name
        drawn.ReferencedROINumber, drawn.ContourSequence = number, []
        seen.ReferencedROINumber, seen.RTROIInterpretedType = number, region.kind
        for points in region.contours:
            each = Dataset()
            each.ContourGeometricType, each.NumberOfContourPoints = "CLOSED_PLANAR", len(points)
            each.ContourData = [f"{value:.3f}" for value in points.ravel()]
            drawn.ContourSequence.append(each)
        made.StructureSetROISequence.append(named)
        made.ROIContourSequence.append(drawn)
        made.RTROIObservationsSequence.append(seen)
    return made


def structures(regions: Sequence[Region], frame: str | None = None) -> bytes:
    """The file."""
    made, stream = structure_set(regions, frame), io.BytesIO()
    made.file_meta = FileMetaDataset()
    made.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
    made.file_meta.MediaStorageSOPClassUID = made.SOPClassUID
    made.file_meta.MediaStorageSOPInstanceUID = made.SOPInstanceUID = generate_uid(entropy_srcs=["a"])
    made.save_as(stream, enforce_file_format=True)
    return stream.getvalue()
