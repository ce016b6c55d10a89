"""Label maps of a breast MRI: the skin where it is, lesions by name or shape, images and damaged files refused."""

import gzip
import io

import highdicom
import numpy as np
import pytest
from helpers.label_maps import BREASTS, CHEST, LESION, LOW, RADIUS, SIZES, body_labels, nifti, places
from pydicom.dataset import FileMetaDataset
from pydicom.sr.codedict import codes
from pydicom.uid import ExplicitVRLittleEndian, generate_uid

from breastrig.core.errors import BadScan, TooLarge
from breastrig.geometry.normals import vertex_normals
from breastrig.scan import read
from breastrig.scan.read import read_scan
from breastrig.scan.volumes import label_map


def off_skin(vertices: np.ndarray) -> np.ndarray:
    """mm, from the body of `body_labels`."""
    to_balls = np.min([np.linalg.norm(vertices - centre, axis=1) - 60.0 for centre in BREASTS], axis=0)
    return np.asarray(np.minimum(to_balls, CHEST - vertices[:, 1]))


@pytest.mark.parametrize(("turned", "packed"), [(False, True), (True, False)])
def test_the_skin_and_the_lesion_lie_where_they_are(turned: bool, packed: bool) -> None:
    data = nifti(body_labels(), turned)
    scan = read_scan(gzip.compress(data) if packed else data)
    assert (scan.unit, scan.from_label_map) == ("mm", True)
    off = np.abs(off_skin(1e3 * scan.vertices))
    assert np.percentile(off, 95) < 0.4
    assert off.max() < 3.0  # in the crease between ball and plane
    assert np.ptp(1e3 * scan.vertices, axis=0) == pytest.approx([259.0, 70.0, 178.0], abs=2.5)
    outwards = vertex_normals(scan.vertices, scan.faces)
    flat = np.abs(1e3 * scan.vertices[:, 1] - CHEST) < 0.2
    assert outwards[flat].mean(axis=0) == pytest.approx([0.0, -1.0, 0.0], abs=0.05)
    (lesion,) = scan.lesions  # the gland is none
    assert 1e3 * lesion.center == pytest.approx(LESION, abs=0.2)
    assert 1e3 * lesion.radius == pytest.approx(RADIUS, abs=0.1)
    assert "Label 2 was found in the label map, 16 mm across." in scan.notes


def test_a_map_of_the_skin_alone_is_the_same_body() -> None:
    labels = body_labels() > 0
    at = places()
    inner = at[..., 1] > CHEST + 4.0
    for centre in BREASTS:
        inner |= np.linalg.norm(at - centre, axis=-1) < 56.0
    scan = read_scan(nifti((labels & ~inner).astype(np.uint8)))
    assert np.percentile(np.abs(off_skin(1e3 * scan.vertices)), 95) < 0.4


def dicom_segmentation(labels: np.ndarray) -> bytes:
    """DICOM SEG of body and lesion over an axial series with rows to the left and columns to the back."""
    from pydicom.dataset import Dataset

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


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_dicom_segmentation_has_its_lesions_by_name() -> None:
    scan = read_scan(dicom_segmentation(body_labels()))
    assert np.percentile(np.abs(off_skin(1e3 * scan.vertices)), 95) < 0.4
    (lesion,) = scan.lesions
    assert lesion.name == "Index lesion Mass"
    assert 1e3 * lesion.center == pytest.approx(LESION, abs=0.2)
    assert 1e3 * lesion.radius == pytest.approx(RADIUS, abs=0.1)


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_segment_that_is_too_large_for_a_lesion_is_none() -> None:
    """A plan takes no such ball, and would be refused as a whole."""
    labels = body_labels()
    labels[labels > 0] = 2
    assert read_scan(dicom_segmentation(labels)).lesions == ()


def test_a_label_that_is_noise_is_no_lesion() -> None:
    labels = body_labels()
    noise = np.random.default_rng(0).random(labels.shape) < 0.001
    labels[noise & (labels == 1)] = 4
    (lesion,) = read_scan(nifti(labels)).lesions
    assert lesion.name == "Label 2"


def test_what_is_no_label_map_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    noise = np.random.default_rng(0).normal(size=(20, 20, 20)).astype(np.float32)
    good = nifti(np.ones((20, 20, 20), np.uint8))
    for data, sentence in (
        (nifti(noise), label_map.IMAGE),
        (nifti(np.arange(8000, dtype=np.int32).reshape(20, 20, 20)), label_map.IMAGE),
        (good, "This label map shows no skin with air in front of it; export the whole volume, 0 for air."),
        (nifti(np.zeros((20, 20, 20), np.uint8)), "This label map shows no skin with air in front of it"),
        (nifti(np.ones((20, 20, 1), np.uint8)), "This label map is a single slice; export the whole volume."),
        (nifti(np.ones((5, 5, 5, 2), np.uint8)), "This label map must be one volume of three dimensions"),
        (good[:2000], "This NIFTI file is damaged or cut off and cannot be read; export it again."),
        (gzip.compress(good)[:-20], "This .gz file is cut off; pack it again."),
        (b"\x1f\x8b" + bytes(40), "This .gz file is damaged; pack it again."),
        (bytes(128) + b"DICM" + bytes(40), label_map.IMAGE),
    ):
        with pytest.raises(BadScan) as caught:
            read_scan(data)
        assert str(caught.value).startswith(sentence)
    monkeypatch.setattr(label_map, "LABEL_MAP_BYTES", 4000)
    with pytest.raises(TooLarge, match="unpacks to more than"):
        read_scan(gzip.compress(good))
    monkeypatch.setattr(label_map, "LABEL_MAP_VOXELS", 1000)
    with pytest.raises(TooLarge, match="more than the 1,000 voxels allowed"):
        read_scan(good)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(BadScan, match=r'need "breastrig\[mri\]"; install it'):
        read_scan(good)
    assert gzip.compress(b"")[:2] == read.GZIP_START
