"""A chest with two half balls for breasts, gland and a lesion inside, as the label map of an MRI."""

import io
import warnings
from collections.abc import Callable
from functools import cache

import highdicom
import nibabel
import numpy as np
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.sr.codedict import codes
from pydicom.uid import UID, ExplicitVRLittleEndian, ImplicitVRLittleEndian, generate_uid
from scipy.interpolate import LinearNDInterpolator

from breastrig.rig.model import Rig

SIZES = np.array([2.0, 2.0, 2.2])  # mm
LOW = np.array([-130.0, -88.0, 66.0])  # mm, LPS
SHAPE = (130, 60, 69)
CHEST = -0.9  # mm, between two layers of voxels
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


def coarse_labels() -> bytes:
    """Every second slice of `body_labels` as NIfTI: half of the work for tests of what is done with a file."""
    return nifti(np.ascontiguousarray(body_labels()[:, :, ::2]), sizes=SIZES * [1.0, 1.0, 2.0])


def front_labels(
    rig: Rig, lesion: np.ndarray, radius: float, size: float = 2.0
) -> tuple[np.ndarray, np.ndarray, float]:
    """`labels_behind` of the template's front from the folds' belly to the collar bones."""
    regions = ("breast_L", "breast_R", "areola_L", "areola_R", "chest", "belly")
    shown = np.unique(np.concatenate([rig.regions[name] for name in regions]))
    front = shown[rig.normals_at(rig.template)[shown, 2] > 0.2]
    return *labels_behind(rig.template[front], lesion, radius, size), size


def labels_behind(
    front: np.ndarray, lesion: np.ndarray, radius: float, size: float = 2.0
) -> tuple[np.ndarray, np.ndarray]:
    """Labels of what lies behind a skin's front: 1 for the body, 2 for a ball inside; voxels of `size` mm.

    And (3,) mm, LPS, of the first voxel.  `front` (N, 3) and `lesion` (3,) m: left, up, front.
    """
    skin = in_lps(front)
    low = np.floor(skin.min(axis=0)) - 6.0
    shape = np.ceil((skin.max(axis=0) - low) / size).astype(int)
    left, back, up = (low[k] + size * np.arange(shape[k]) for k in range(3))
    depth = LinearNDInterpolator(skin[:, [0, 2]], skin[:, 1])(left[:, None], up[None, :])
    labels = (back[None, :, None] > depth[:, None, :]).astype(np.uint8)  # nothing where it is not known
    away = [(axis - middle) ** 2 for axis, middle in zip((left, back, up), in_lps(lesion), strict=True)]
    labels[(away[0][:, None, None] + away[1][:, None] + away[2]) < radius**2] = 2
    return labels, low


def above_navel(labels: np.ndarray, low: np.ndarray, size: float, end: float = 200.0) -> tuple[np.ndarray, np.ndarray]:
    """Of `front_labels`, as a breast MRI has it: its field of view ends at `end` mm, 40 above the template's navel."""
    cut = int((end - low[2]) / size)
    return np.ascontiguousarray(labels[:, :, cut:]), low + np.array([0.0, 0.0, size * cut])


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


Words = tuple[str, str, str, str, str]  # label, category's code and meaning, type's code and meaning
BODY_WORDS: Words = ("Body", "85756007", "Tissue", "76752008", "Breast")
LESION_WORDS: Words = ("Index lesion", "49755003", "Morphologically abnormal structure", "4147007", "Mass")
PLAIN: Words = ("Segment", "85756007", "Tissue", "85756007", "Tissue")


def coded(value: str, meaning: str) -> Dataset:
    code = Dataset()
    code.CodeValue, code.CodingSchemeDesignator, code.CodeMeaning = value, "SCT", meaning
    return code


def seg(
    masks: dict[int, np.ndarray],
    words: dict[int, Words] | None = None,
    kind: str = "BINARY",
    absent: Callable[[int, int], bool] = lambda number, at: False,
    order: np.ndarray | None = None,
    turned: bool = False,
    jitter: float = 0.0,
    shares: bool = True,
    spacing: bool = True,
    thickness: bool = False,
) -> Dataset:
    """A DICOM segmentation with what its frames need and hardly anything else; masks (I, J, K) by segment numbers.

    `absent` leaves frames out, `order` puts them into another one, `turned` has the rows run from the left to the
    right, `shares` puts what all frames have in common into one place, `jitter` (mm) moves frames along the slices.
    """
    rng = np.random.default_rng(0)
    made = Dataset()
    made.SOPClassUID = "1.2.840.10008.5.1.4.1.1.66.7" if kind == "LABELMAP" else "1.2.840.10008.5.1.4.1.1.66.4"
    made.Modality, made.SegmentationType, made.SpecificCharacterSet = "SEG", kind, "ISO_IR 192"
    shape = next(iter(masks.values())).shape
    made.Rows, made.Columns = shape[1], shape[0]
    side = -1.0 if turned else 1.0
    frames = []
    if kind == "LABELMAP":
        labels = np.zeros(shape, np.uint8)
        for number, mask in masks.items():
            labels[mask] = number
        frames = [(None, at, labels[:, :, at]) for at in range(shape[2]) if not absent(0, at)]
    else:
        for number, mask in masks.items():
            frames += [(number, at, mask[:, :, at]) for at in range(shape[2]) if mask[:, :, at].any()]
        frames = [each for each in frames if not absent(each[0] or 0, each[1])]
    frames = frames if order is None else [frames[at] for at in np.argsort(order[: len(frames)], kind="stable")]
    groups, pixels = [], []
    orientation, measures = Dataset(), Dataset()
    orientation.ImageOrientationPatient = [side, 0, 0, 0, 1, 0]
    measures.PixelSpacing = [SIZES[1], SIZES[0]]
    if spacing:
        measures.SpacingBetweenSlices = SIZES[2]
    if thickness:
        measures.SliceThickness = SIZES[2]
    for number, at, content in frames:
        group, place = Dataset(), Dataset()
        left = LOW[0] + (SIZES[0] * (shape[0] - 1) if turned else 0.0)
        place.ImagePositionPatient = [left, LOW[1], LOW[2] + SIZES[2] * at + jitter * (rng.random() - 0.5)]
        group.PlanePositionSequence = [place]
        if number is not None:
            which = Dataset()
            which.ReferencedSegmentNumber = number
            group.SegmentIdentificationSequence = [which]
        if not shares:
            group.PlaneOrientationSequence, group.PixelMeasuresSequence = [orientation], [measures]
        groups.append(group)
        pixels.append((content[::-1] if turned else content).T)
    made.PerFrameFunctionalGroupsSequence = groups
    if shares:
        shared = Dataset()
        shared.PlaneOrientationSequence, shared.PixelMeasuresSequence = [orientation], [measures]
        made.SharedFunctionalGroupsSequence = [shared]
    made.NumberOfFrames = len(frames)
    segments = []
    for number in masks:
        each, said = Dataset(), (words or {1: BODY_WORDS, 2: LESION_WORDS}).get(number, PLAIN)
        each.SegmentNumber, each.SegmentLabel = number, said[0]
        if said[1]:
            each.SegmentedPropertyCategoryCodeSequence = [coded(said[1], said[2])]
            each.SegmentedPropertyTypeCodeSequence = [coded(said[3], said[4])]
        segments.append(each)
    made.SegmentSequence = segments
    stack = np.stack(pixels).astype(np.uint8)
    made.BitsAllocated = made.BitsStored = 1 if kind == "BINARY" else 8
    if kind == "FRACTIONAL":
        made.MaximumFractionalValue, stack = 200, 200 * stack
    content = np.packbits(stack.ravel(), bitorder="little").tobytes() if kind == "BINARY" else stack.tobytes()
    made.add_new("PixelData", "OB", content + bytes(len(content) % 2))
    return made


def file_of(dataset: Dataset, syntax: str = ExplicitVRLittleEndian, header: bool = True) -> bytes:
    """The file; without `header` it begins with its first element, as older programs write it."""
    stream = io.BytesIO()
    dataset.file_meta = FileMetaDataset()
    dataset.file_meta.TransferSyntaxUID = UID(syntax)
    dataset.file_meta.MediaStorageSOPClassUID = dataset.SOPClassUID
    dataset.file_meta.MediaStorageSOPInstanceUID = dataset.SOPInstanceUID = generate_uid(entropy_srcs=["a"])
    if not header:
        del dataset.file_meta
        dataset.save_as(stream, implicit_vr=syntax == ImplicitVRLittleEndian, little_endian=True)
        return stream.getvalue()
    dataset.save_as(stream, enforce_file_format=True)
    return stream.getvalue()


def masks() -> dict[int, np.ndarray]:
    """The body with all in it, and the lesion, of `body_labels`."""
    labels = body_labels()
    return {1: labels > 0, 2: labels == 2}


def dicom_segmentation(
    labels: np.ndarray, low: np.ndarray = LOW, sizes: np.ndarray = SIZES, frame: str = "", lesion_alone: bool = False
) -> bytes:
    """DICOM SEG of body and lesion over an axial series with rows to the left and columns to the back."""
    study, series, frame = generate_uid(), generate_uid(), frame or generate_uid()
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
        each.ImagePositionPatient = [*low[:2], low[2] + sizes[2] * number]
        each.ImageOrientationPatient = [1, 0, 0, 0, 1, 0]
        each.PixelSpacing, each.SliceThickness = [sizes[1], sizes[0]], sizes[2]
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
        if number == 2 or not lesion_alone
    ]
    frames = np.stack([np.moveaxis(labels > 0, 2, 0), np.moveaxis(labels == 2, 2, 0)], axis=-1).swapaxes(1, 2)
    if lesion_alone:
        frames, described[0].SegmentNumber = frames[..., 1:], 1
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
