"""Label maps of a breast MRI: the skin where it is, lesions by name or shape, images and damaged files refused."""

import gzip

import nibabel
import numpy as np
import pytest
from helpers.label_maps import (
    BREASTS,
    CHEST,
    LESION,
    LOW,
    RADIUS,
    SIZES,
    body_labels,
    dicom_segmentation,
    nifti,
    places,
    to_ras,
)

from breastrig.core.errors import BadScan, TooLarge
from breastrig.geometry.normals import vertex_normals
from breastrig.scan import read
from breastrig.scan.read import read_scan
from breastrig.scan.volumes import gzipped, segments, volume
from breastrig.scan.volumes.grids.grid import Grid
from breastrig.scan.volumes.volume_files import read_volume


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
    assert np.percentile(off, 95) < 0.55
    assert off.max() < 3.0  # in the crease between ball and plane
    assert np.ptp(1e3 * scan.vertices, axis=0) == pytest.approx([259.0, 70.0, 150.0], abs=2.5)
    outwards = vertex_normals(scan.vertices, scan.faces)
    flat = np.abs(1e3 * scan.vertices[:, 1] - CHEST) < 0.2
    assert outwards[flat].mean(axis=0) == pytest.approx([0.0, -1.0, 0.0], abs=0.05)
    (lesion,) = scan.lesions  # the gland is none
    assert 1e3 * lesion.center == pytest.approx(LESION, abs=0.2)
    assert 1e3 * lesion.radius == pytest.approx(RADIUS, abs=0.1)
    said = "Segment 2 of the file was taken for a lesion (Lesion 1, 16 mm across). It is small, compact and inside"
    assert any(note.startswith(said) for note in scan.notes)
    assert [(each.number, each.taken_as) for each in scan.segments] == [(1, "tissue"), (2, "lesion"), (3, "tissue")]


def test_a_map_of_the_skin_alone_is_the_same_body() -> None:
    labels = body_labels() > 0
    at = places()
    inner = at[..., 1] > CHEST + 4.0
    for centre in BREASTS:
        inner |= np.linalg.norm(at - centre, axis=-1) < 56.0
    scan = read_scan(nifti((labels & ~inner).astype(np.uint8)))
    assert np.percentile(np.abs(off_skin(1e3 * scan.vertices)), 95) < 0.55


def test_a_dicom_segmentation_has_its_lesions_by_name() -> None:
    scan = read_scan(dicom_segmentation(body_labels()))
    assert np.percentile(np.abs(off_skin(1e3 * scan.vertices)), 95) < 0.55
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
    labels = body_labels()[PART]
    noise = np.random.default_rng(0).random(labels.shape) < 0.001
    labels[noise & (labels == 1)] = 4
    (lesion,) = read_scan(nifti(labels)).lesions
    assert lesion.name == "Lesion 1"


def test_what_is_no_label_map_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    small = nifti(np.ones((20, 20, 20), np.uint8))
    good = nifti(np.ones((90, 90, 90), np.uint8))
    for data, sentence in (
        (good, "This label map shows no skin with air in front of it; export the whole volume, 0 for air."),
        (small, "This label map shows no body: all that is in it is 44 mm across, as a lesion alone"),
        (nifti(np.zeros((20, 20, 20), np.uint8)), "This label map shows no skin with air in front of it"),
        (nifti(np.ones((20, 20, 1), np.uint8)), "This file is a single slice; export the whole volume."),
        (nifti(np.ones((5, 5, 5, 2), np.uint8)), "This file must be one volume of three dimensions"),
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


PART = np.s_[55:, :, 24:64]  # a breast with the lesion, and what is around it
PART_LOW = LOW + SIZES * [55.0, 0.0, 24.0]


def stored(labels: np.ndarray, dtype: type, kind: type = nibabel.Nifti1Image, order: str = "<") -> bytes:
    header = kind.header_class(endianness=order)
    image = kind(labels.astype(dtype), to_ras(PART_LOW), header)
    image.header.set_xyzt_units("mm")
    return bytes(image.to_bytes())


def scaled(labels: np.ndarray, dtype: type) -> bytes:
    """Floats that nibabel stretches over all numbers of a kind."""
    image = nibabel.Nifti1Image(labels.astype(np.float64), to_ras(PART_LOW))
    image.set_data_dtype(dtype)
    return bytes(image.to_bytes())


def test_labels_are_read_however_they_are_stored() -> None:
    labels = body_labels()[PART]
    noise = np.random.default_rng(0).normal(0.0, 1e-4, labels.shape)
    with_nan = np.where(labels == 0, np.nan, labels)
    plain, holed = stored(labels, np.uint8), stored(with_nan, np.float32)
    for data in (
        gzip.compress(plain[:5000]) + gzip.compress(plain[5000:]) + bytes(512),
        stored(labels, np.uint16, order=">"),
        stored(labels, np.float64, nibabel.Nifti2Image),
        stored(labels[..., None], np.uint8),
        stored(labels + noise, np.float32),
        holed,
        scaled(labels, np.uint8),
        scaled(200.0 * (labels == 2) + 3.0 * (labels > 0), np.uint8),
    ):
        scan = read_scan(data)
        (lesion,) = scan.lesions
        assert 1e3 * lesion.center == pytest.approx(LESION, abs=0.2)
        assert 1e3 * lesion.radius == pytest.approx(RADIUS, abs=0.1)
        assert ("Voxels without a number (NaN) were taken for air." in scan.notes) == (data is holed)


def test_an_image_is_none_whatever_it_is_stored_as() -> None:
    rng = np.random.default_rng(0)
    body = body_labels()[PART]
    grey = np.clip(rng.normal(100.0, 30.0, body.shape), 1, 255) * (body > 0)
    colours = np.zeros(body.shape, [("R", "u1"), ("G", "u1"), ("B", "u1")])
    for data in (
        stored(grey, np.uint8),  # of no more values than labels may have
        stored(grey, np.float32),
        scaled(grey, np.uint8),
        stored(np.where(body == 2, np.inf, body), np.float32),
    ):
        assert isinstance(read_volume(data, "nifti", None), Grid)
    for data in (
        bytes(nibabel.Nifti1Image(body.astype(np.complex64), to_ras(PART_LOW)).to_bytes()),
        bytes(nibabel.Nifti1Image(colours, to_ras(PART_LOW)).to_bytes()),
    ):
        with pytest.raises(BadScan, match="no single grey value or label for each voxel"):
            read_scan(data)


def test_small_files_do_not_ask_for_much(monkeypatch: pytest.MonkeyPatch) -> None:
    """Voxels of a micrometre, and labels that are scattered everywhere."""
    for size in (1e-3, 1e-6, 500.0):
        with pytest.raises(BadScan, match="which those of no body are; check its unit"):
            read_scan(nifti(body_labels(), sizes=np.full(3, size)))
    labels = body_labels()
    for number in range(4, 60):
        labels[number * 3 % 130, 39 + number % 15, :] = number
    looked_at = []
    parts = segments._parts
    monkeypatch.setattr(segments, "LOOKED_AT", 100_000)
    monkeypatch.setattr(segments, "_parts", lambda inside, *rest: looked_at.append(inside.size) or parts(inside, *rest))
    scan = read_scan(nifti(labels))
    assert sum(looked_at) <= 100_000
    assert len(scan.segments) == 59
    assert any(note.startswith("The other") and "were taken for tissue" in note for note in scan.notes)
    assert len(scan.notes) < 10


def test_a_map_of_one_breast_is_said_to_be_one() -> None:
    labels = body_labels()
    half = read_scan(nifti(labels[65:], low=LOW + SIZES * [65.0, 0.0, 0.0]))
    (said,) = [note for note in half.notes if "as one breast alone" in note]
    assert " mm wide from right to left" in said
    assert not any("one breast" in note for note in read_scan(nifti(labels)).notes)
