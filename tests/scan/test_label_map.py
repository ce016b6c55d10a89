"""Label maps of a breast MRI: the skin where it is, lesions by name or shape, images and damaged files refused."""

import gzip

import numpy as np
import pytest
from helpers.label_maps import BREASTS, CHEST, LESION, RADIUS, body_labels, dicom_segmentation, nifti, places

from breastrig.core.errors import BadScan, TooLarge
from breastrig.geometry.normals import vertex_normals
from breastrig.scan import read
from breastrig.scan.read import read_scan
from breastrig.scan.volumes import gzipped, volume
from breastrig.scan.volumes.volume import IMAGE


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
    said = "Segment 2 of the label map was taken for a lesion (Lesion 1, 16 mm across): it is small, compact and inside"
    assert any(note.startswith(said) for note in scan.notes)
    assert [(each.number, each.taken_as) for each in scan.segments] == [(1, "tissue"), (2, "lesion"), (3, "tissue")]


def test_a_map_of_the_skin_alone_is_the_same_body() -> None:
    labels = body_labels() > 0
    at = places()
    inner = at[..., 1] > CHEST + 4.0
    for centre in BREASTS:
        inner |= np.linalg.norm(at - centre, axis=-1) < 56.0
    scan = read_scan(nifti((labels & ~inner).astype(np.uint8)))
    assert np.percentile(np.abs(off_skin(1e3 * scan.vertices)), 95) < 0.4


def test_a_dicom_segmentation_has_its_lesions_by_name() -> None:
    scan = read_scan(dicom_segmentation(body_labels()))
    assert np.percentile(np.abs(off_skin(1e3 * scan.vertices)), 95) < 0.4
    (lesion,) = scan.lesions
    assert lesion.name == "Lesion 1"
    assert [each.label for each in scan.segments] == ["Body Breast", "Index lesion Mass"]
    assert "Index" not in " ".join(scan.notes)
    assert 1e3 * lesion.center == pytest.approx(LESION, abs=0.2)
    assert 1e3 * lesion.radius == pytest.approx(RADIUS, abs=0.1)


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
    assert lesion.name == "Lesion 1"


def test_what_is_no_label_map_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    noise = np.random.default_rng(0).normal(size=(20, 20, 20)).astype(np.float32)
    small = nifti(np.ones((20, 20, 20), np.uint8))
    good = nifti(np.ones((90, 90, 90), np.uint8))
    for data, sentence in (
        (nifti(noise), IMAGE),
        (nifti(np.arange(8000, dtype=np.int32).reshape(20, 20, 20)), IMAGE),
        (good, "This label map shows no skin with air in front of it; export the whole volume, 0 for air."),
        (small, "This label map shows no body: all that is in it is 40 mm across, as a lesion alone"),
        (nifti(np.zeros((20, 20, 20), np.uint8)), "This label map shows no skin with air in front of it"),
        (nifti(np.ones((20, 20, 1), np.uint8)), "This label map is a single slice; export the whole volume."),
        (nifti(np.ones((5, 5, 5, 2), np.uint8)), "This label map must be one volume of three dimensions"),
        (good[:2000], "This NIFTI file is damaged or cut off and cannot be read; export it again."),
        (gzip.compress(good)[:-20], "This .gz file is cut off; pack it again."),
        (b"\x1f\x8b" + bytes(40), "This .gz file is damaged; pack it again."),
        (bytes(128) + b"DICM" + bytes(40), "This DICOM file"),
    ):
        with pytest.raises(BadScan) as caught:
            read_scan(data)
        assert str(caught.value).startswith(sentence)
    monkeypatch.setattr(gzipped, "LABEL_MAP_BYTES", 4000)
    with pytest.raises(TooLarge, match="unpacks to more than"):
        read_scan(gzip.compress(good))
    monkeypatch.setattr(volume, "LABEL_MAP_VOXELS", 1000)
    with pytest.raises(TooLarge, match="more than the 1,000 voxels allowed"):
        read_scan(good)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(BadScan, match=r'need "breastrig\[mri\]"; install it'):
        read_scan(good)
    assert gzip.compress(b"")[:2] == read.GZIP_START
