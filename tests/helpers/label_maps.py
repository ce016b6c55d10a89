"""A chest with two half balls for breasts, gland and a lesion inside, as the label map of an MRI."""

import io
import warnings
from functools import cache

import highdicom
import nibabel
import numpy as np
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.sr.codedict import codes
from pydicom.uid import ExplicitVRLittleEndian, generate_uid
from scipy.interpolate import LinearNDInterpolator

from breastrig.rig.model import Rig

SIZES = np.array([1.0, 1.1, 2.0])  # mm
LOW = np.array([-130.0, -100.0, 50.0])  # mm, LPS
SHAPE = (260, 160, 90)
CHEST = -0.45  # mm, between two layers of voxels
BREASTS = np.array([[65.0, -10.0, 140.0], [-65.0, -10.0, 140.0]])
LESION, RADIUS = np.array([60.0, -35.0, 150.0]), 8.0


def places() -> np.ndarray:
    return np.stack(np.meshgrid(*[LOW[k] + SIZES[k] * np.arange(SHAPE[k]) for k in range(3)], indexing="ij"), axis=-1)


def body_labels() -> np.ndarray:
    """1 for a chest behind y = 0 with two half balls of 60 mm before it, 2 for a ball inside, 3 for gland."""
    return _body_labels().copy()


@cache
def _body_labels() -> np.ndarray:
    at = places()
    body = at[..., 1] > CHEST
    for centre in BREASTS:
        body |= np.linalg.norm(at - centre, axis=-1) < 60.0
    labels = body.astype(np.uint8)
    gland = body & (np.abs(at - BREASTS[1]).max(axis=-1) < 40.0) & (np.abs(at - BREASTS[1]).min(axis=-1) < 2.0)
    labels[gland & (np.linalg.norm(at - BREASTS[1], axis=-1) < 40.0)] = 3
    labels[np.linalg.norm(at - LESION, axis=-1) < RADIUS] = 2
    return labels


def front_labels(rig: Rig, lesion: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Labels of the template's front from the folds' belly to the collar bones: 1 for the body, 2 for a ball inside.

    And (3,) mm, LPS, of the first voxel, and the voxels' size.  `lesion` is (3,) m in the template's frame.
    """
    regions = ("breast_L", "breast_R", "areola_L", "areola_R", "chest", "belly")
    shown = np.unique(np.concatenate([rig.regions[name] for name in regions]))
    front = shown[rig.normals_at(rig.template)[shown, 2] > 0.2]
    skin = in_lps(rig.template[front])
    size, low = 2.0, np.floor(skin.min(axis=0)) - 6.0
    shape = np.ceil((skin.max(axis=0) - low) / size).astype(int)
    left, back, up = (low[k] + size * np.arange(shape[k]) for k in range(3))
    depth = LinearNDInterpolator(skin[:, [0, 2]], skin[:, 1])(left[:, None], up[None, :])
    labels = (back[None, :, None] > depth[:, None, :]).astype(np.uint8)  # nothing where it is not known
    away = [(axis - middle) ** 2 for axis, middle in zip((left, back, up), in_lps(lesion), strict=True)]
    labels[(away[0][:, None, None] + away[1][:, None] + away[2]) < radius**2] = 2
    return labels, low, size


def in_lps(points: np.ndarray) -> np.ndarray:
    """(..., 3) mm of (..., 3) m in the template's frame: left, up, front."""
    return 1e3 * points[..., [0, 2, 1]] * [1.0, -1.0, 1.0]


def placed_nifti(labels: np.ndarray, sform: tuple[np.ndarray, int], qform: tuple[np.ndarray, int]) -> bytes:
    """With both places of the header, each an affine to RAS and its code."""
    image = nibabel.Nifti1Image(labels, None)
    image.set_sform(sform[0], sform[1])
    image.set_qform(qform[0], qform[1])
    image.header.set_xyzt_units("mm")
    return bytes(image.to_bytes())


def to_ras(low: np.ndarray = LOW, sizes: np.ndarray = SIZES) -> np.ndarray:
    """(4, 4) where the voxels of `body_labels` lie, in RAS."""
    affine = np.diag([*sizes, 1.0])
    affine[:3, 3] = low
    return np.asarray(np.diag([-1.0, -1.0, 1.0, 1.0]) @ affine)


def nifti(labels: np.ndarray, turned: bool = False, low: np.ndarray = LOW, sizes: np.ndarray = SIZES) -> bytes:
    """As NIfTI has it, RAS; `turned` with the voxels stored in another order, which changes nothing."""
    image = nibabel.Nifti1Image(labels, to_ras(low, sizes))
    image.header.set_xyzt_units("mm")
    if turned:
        image = image.as_reoriented(nibabel.orientations.axcodes2ornt(("S", "R", "P")))
    return bytes(image.to_bytes())


def dicom_segmentation(labels: np.ndarray) -> bytes:
    """DICOM SEG of body and lesion over an axial series with rows to the left and columns to the back."""
    study, series, frame = generate_uid(), generate_uid(), generate_uid()
    sources = []
    for number in range(labels.shape[2]):
        each = Dataset()
        each.file_meta = FileMetaDataset()
        each.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
        each.SOPClassUID, each.SOPInstanceUID = "1.2.840.10008.5.1.4.1.1.4", generate_uid()
        each.StudyInstanceUID, each.SeriesInstanceUID, each.FrameOfReferenceUID = study, series, frame
        each.PatientID = each.PatientName = each.PatientBirthDate = each.PatientSex = each.AccessionNumber = ""
        each.StudyID = each.StudyDate = each.StudyTime = each.ReferringPhysicianName = ""
        each.Modality, each.InstanceNumber, each.PositionReferenceIndicator = "MR", number + 1, ""
        each.ImagePositionPatient = [*LOW[:2], LOW[2] + SIZES[2] * number]
        each.ImageOrientationPatient = [1, 0, 0, 0, 1, 0]
        each.PixelSpacing, each.SliceThickness = [SIZES[1], SIZES[0]], SIZES[2]
        each.Rows, each.Columns = labels.shape[1], labels.shape[0]
        sources.append(each)
    described = [
        highdicom.seg.SegmentDescription(
            segment_number=number,
            segment_label=label,
            segmented_property_category=codes.SCT.MorphologicallyAbnormalStructure,
            segmented_property_type=kind,
            algorithm_type="MANUAL",
        )
        for number, label, kind in ((1, "Body", codes.SCT.Breast), (2, "Index lesion", codes.SCT.Mass))
    ]
    frames = np.stack([np.moveaxis(labels > 0, 2, 0), np.moveaxis(labels == 2, 2, 0)], axis=-1).swapaxes(1, 2)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # highdicom's, of a series without some of its attributes
        made = highdicom.seg.Segmentation(
            sources,
            frames.astype(np.uint8),
            "BINARY",
            described,
            generate_uid(),
            1,
            generate_uid(),
            1,
            "us",
            "test",
            "1",
            "1",
        )
    stream = io.BytesIO()
    made.save_as(stream, enforce_file_format=True)
    return stream.getvalue()
