"""DICOM segmentations: whatever their frames need and no more, segments on their own voxels, missing frames."""

import io
import re
import zipfile
import zlib

import numpy as np
import pytest
from helpers.label_maps import (
    BODY_WORDS,
    BREASTS,
    CHEST,
    LESION,
    LESION_WORDS,
    LOW,
    PLAIN,
    RADIUS,
    SIZES,
    Words,
    file_of,
    masks,
    nifti,
    places,
    seg,
)
from pydicom.dataset import Dataset
from pydicom.encaps import encapsulate
from pydicom.uid import (
    UID,
    DeflatedExplicitVRLittleEndian,
    ExplicitVRLittleEndian,
    ImplicitVRLittleEndian,
    RLELossless,
)

import breastrig
from breastrig.core.errors import BadInput, BadScan, TooLarge
from breastrig.scan.read import read_scan
from breastrig.scan.scan import Scan
from breastrig.scan.volumes import dicom_seg
from breastrig.scan.volumes.answers import checked_answers

OFF = 0.55  # mm, a quarter of a voxel


def off_skin(scan: Scan) -> float:
    """mm, the 95th percentile from the body of `body_labels`."""
    at = 1e3 * scan.vertices
    to_balls = np.min([np.linalg.norm(at - centre, axis=1) - 60.0 for centre in BREASTS], axis=0)
    return float(np.percentile(np.abs(np.minimum(to_balls, CHEST - at[:, 1])), 95))


def check(scan: Scan, off: float = OFF) -> None:
    """Skin and lesion lie where they are."""
    assert off_skin(scan) < off
    (lesion,) = scan.lesions
    assert 1e3 * lesion.center == pytest.approx(LESION, abs=0.3)
    assert 1e3 * lesion.radius == pytest.approx(RADIUS, abs=0.15)


def test_what_frames_need_is_enough() -> None:
    """Place, orientation, spacing and segment; in any order, shared or of each frame's own, with rounded places."""
    check(read_scan(file_of(seg(masks(), order=np.random.default_rng(1).random(400)))))
    check(read_scan(file_of(seg(masks(), turned=True))))
    check(read_scan(file_of(seg(masks(), shares=False, spacing=False, jitter=0.2))))


@pytest.mark.parametrize("kind", ["FRACTIONAL", "LABELMAP"])
def test_each_type_of_segmentation_is_read(kind: str) -> None:
    check(read_scan(file_of(seg(masks(), kind=kind))))


@pytest.mark.parametrize(
    ("syntax", "header"),
    [
        (ExplicitVRLittleEndian, False),
        (ImplicitVRLittleEndian, False),
        (DeflatedExplicitVRLittleEndian, True),
    ],
)
def test_every_way_of_writing_the_file_is_read(syntax: str, header: bool) -> None:
    data = file_of(seg(masks()), syntax, header)
    check(read_scan(data))
    if header:
        check(read_scan(data[128:]))  # without the bytes before the mark


def test_runs_of_equal_pixels_are_unpacked() -> None:
    from pydicom.pixels.encoders import RLELosslessEncoder

    made = seg(masks(), kind="LABELMAP")
    size = made.Rows * made.Columns
    facts = {"rows": made.Rows, "columns": made.Columns, "samples_per_pixel": 1, "bits_allocated": 8, "bits_stored": 8}
    facts |= {"pixel_representation": 0, "photometric_interpretation": "MONOCHROME2", "number_of_frames": 1}
    frames = [made.PixelData[at * size : (at + 1) * size] for at in range(made.NumberOfFrames)]
    packed = [RLELosslessEncoder.encode(frame, **facts) for frame in frames]
    made.PixelData = encapsulate(packed)
    made["PixelData"].is_undefined_length = True
    made.file_meta = None
    check(read_scan(file_of(made, RLELossless)))


@pytest.mark.parametrize(
    ("words", "what"),
    [
        (("L\u00e4sion links", *PLAIN[1:]), "lesion"),
        (("Herd", *PLAIN[1:]), "lesion"),
        (("Segment_2", *PLAIN[1:]), "lesion"),
        (("\u75c5\u53d8", *PLAIN[1:]), "lesion"),
        (("GTVp", "", "", "", ""), "lesion"),
        (("", "", "", "", ""), "lesion"),
        (("ROI 2", "49755003", "Morphologically abnormal structure", "27925004", "Nodule"), "lesion"),
        (("ROI", "85756007", "Tissue", "21793004", "Connective tissue"), "lesion"),
        (("ROI", "123037004", "Anatomical structure", "76752008", "Breast"), "lesion"),
        (("ROI", "123037004", "Anatomical structure", "59441001", "Lymph node"), "tissue"),
    ],
)
def test_codes_and_form_decide_what_a_segment_is(words: Words, what: str) -> None:
    part = {number: mask[60:, :, 20:55] for number, mask in masks().items()}
    scan = read_scan(file_of(seg(part, {1: ("K\u00f6rper", *PLAIN[1:]), 2: words})))
    assert [each.taken_as for each in scan.segments] == ["tissue", what]
    assert [each.name for each in scan.segments] == ["Tissue 1", "Lesion 1" if what == "lesion" else "Tissue 2"]
    assert [lesion.name for lesion in scan.lesions] == (["Lesion 1"] if what == "lesion" else [])
    assert sum(note.startswith("Segment ") for note in scan.notes) == 2  # of each it is said what became of it
    assert not any(word and word in note for note in scan.notes for word in (words[0], "K\u00f6rper"))


def test_a_person_may_say_otherwise() -> None:
    data = file_of(seg(masks(), {1: BODY_WORDS, 2: ("ROI", "123037004", "Anatomical structure", "59441001", "Node")}))
    assert breastrig.read_scan(data).in_metres.lesions == ()
    scan = breastrig.read_scan(data, segments={2: "lesion"})
    assert scan.segments[1].why == "A person said so."
    check(scan.in_metres)
    for given, sentence in (
        ({3: "lesion"}, "There is no segment 3 in this file; it has 1, 2."),
        ({2: "skin"}, "A segment can be lesion, tissue or unused"),
        ({1: "lesion"}, "Segment 1 can be no lesion: it is more than 160 mm across"),
        ({1: "unused"}, "This label map shows no body"),
    ):
        with pytest.raises(BadInput, match=sentence):
            breastrig.read_scan(data, segments=given)


def test_what_is_left_out_is_no_skin() -> None:
    """A table that somebody has segmented, too."""
    at = places()
    table = (at[..., 1] < -78.0) & (at[..., 1] > -84.0) & (np.abs(at[..., 0]) < 80.0)
    data = file_of(seg(masks() | {3: table}))
    assert off_skin(read_scan(data)) > 5.0
    check(read_scan(data, answers=checked_answers(None, {3: "unused"})))


def test_segments_that_overlap_keep_their_own_voxels() -> None:
    """Two readers' contours of one lesion, and a core inside it."""
    away = np.linalg.norm(places() - LESION, axis=-1)
    other = np.linalg.norm(places() - LESION - [4.0, 0.0, 0.0], axis=-1)
    found = masks() | {2: away < 9.0, 3: other < 9.0, 4: away < 4.0}
    words = {1: BODY_WORDS, 2: LESION_WORDS, 3: LESION_WORDS, 4: LESION_WORDS}
    scan = read_scan(file_of(seg(found, words)))
    assert [1e3 * each.radius for each in scan.lesions] == pytest.approx([9.0, 9.0, 4.0], abs=0.2)
    assert off_skin(scan) < OFF


def test_one_missing_frame_is_bridged_and_said() -> None:
    middle = round((140.0 - LOW[2]) / SIZES[2])
    scan = read_scan(file_of(seg(masks(), absent=lambda number, at: number == 1 and at == middle)))
    check(scan)
    said = "Segment 1 has no frame in a slice between others; the neighbours were joined there."
    assert said in scan.notes
    labelled = read_scan(file_of(seg(masks(), kind="LABELMAP", absent=lambda number, at: at == middle)))
    assert off_skin(labelled) < OFF


def test_every_second_frame_that_is_missing_is_bridged_and_said() -> None:
    scan = read_scan(file_of(seg(masks(), absent=lambda number, at: at % 2 == 1)))
    assert off_skin(scan) < 0.9
    (lesion,) = scan.lesions
    assert 1e3 * lesion.center == pytest.approx(LESION, abs=0.5)
    assert 1e3 * lesion.radius == pytest.approx(RADIUS, abs=0.7)  # its first and last frame are among the missing
    assert any(re.search(r"Segment 2 has no frame in \d single slices", note) for note in scan.notes)
    assert len(read_scan(file_of(seg(masks(), absent=lambda number, at: at % 2 == 1, spacing=False))).lesions) == 1


def test_frames_that_may_be_missing_are_said_where_only_the_thickness_tells() -> None:
    def notes(*, every: int, spacing: bool, thickness: bool) -> list[str]:
        made = seg(masks(), absent=lambda number, at: at % every > 0, spacing=spacing, thickness=thickness)
        return [note for note in read_scan(file_of(made)).notes if "frames may be missing" in note]

    for every in (2, 3):
        (said,) = notes(every=every, spacing=False, thickness=True)
        assert said.startswith(f"Frames lie {every * SIZES[2]:.3g} mm apart, {every} times the slices' thickness")
    assert notes(every=1, spacing=False, thickness=True) == []
    assert notes(every=2, spacing=False, thickness=False) == []
    assert notes(every=2, spacing=True, thickness=True) == [], "they are bridged"


def test_several_missing_frames_leave_the_skin_open_there_and_are_said() -> None:
    scan = read_scan(file_of(seg(masks(), absent=lambda number, at: 40 <= at <= 42)))
    assert "3 slices are missing between others, more than one in a row; the skin is open there." in scan.notes
    height = 1e3 * scan.vertices[np.unique(scan.faces), 2]
    low, high = LOW[2] + SIZES[2] * 40.0, LOW[2] + SIZES[2] * 42.0
    assert not ((height > low) & (height < high)).any()
    assert np.percentile(np.abs(height - 0.5 * (low + high)), 1) > 2.0


def test_an_empty_slice_of_a_nifti_is_bridged_and_said() -> None:
    from helpers.label_maps import body_labels

    labels = body_labels()
    labels[:, :, 34] = 0
    scan = read_scan(nifti(labels))
    assert off_skin(scan) < OFF
    assert "An empty slice between others was filled from the neighbours." in scan.notes
    labels[:, :, 33:36] = 0
    assert any("3 slices are missing" in note for note in read_scan(nifti(labels)).notes)


def test_a_lesion_in_two_parts_has_a_number_for_each() -> None:
    apart = np.linalg.norm(places() - LESION - [0.0, 0.0, -24.0], axis=-1) < 5.0
    scan = read_scan(file_of(seg(masks() | {2: masks()[2] | apart})))
    assert [each.name for each in scan.lesions] == ["Lesion 1, part 1", "Lesion 1, part 2"]
    assert sorted(1e3 * each.radius for each in scan.lesions) == pytest.approx([5.0, 8.0], abs=0.2)


def other(sop_class: str, modality: str, **facts: object) -> bytes:
    made = Dataset()
    made.SOPClassUID, made.Modality = UID(sop_class), modality
    for name, value in facts.items():
        setattr(made, name, value)
    return file_of(made)


def test_what_is_no_segmentation_is_said_truly() -> None:
    structures = other("1.2.840.10008.5.1.4.1.1.481.3", "RTSTRUCT")
    colours = {"SamplesPerPixel": 3, "BitsAllocated": 8, "Rows": 4, "Columns": 4, "PixelData": bytes(48)}
    for data, sentence in (
        (structures, "This is a structure set (RTSTRUCT), which shows no skin; give it with its image, or export"),
        (
            other("1.2.840.10008.5.1.4.1.1.7", "OT", **colours),
            "These DICOM images are no MR images",
        ),
        (other("1.2.840.10008.5.1.4.1.1.4", "MR", Rows=4, Columns=4), "This DICOM file holds neither"),
        (other("1.2.840.10008.5.1.4.1.1.88.11", "SR"), "This DICOM file holds neither an image nor a segmentation"),
        (other("1.2.840.10008.5.1.4.1.1.66.5", "SEG"), "This is a DICOM surface segmentation"),
        (file_of(seg(masks()))[:-2000], dicom_seg.DAMAGED),
        (nifti(np.ones((9, 9, 9), np.uint8))[:344] + b"ni1\0" + bytes(4), "This is half of a NIfTI file"),
    ):
        with pytest.raises(BadScan) as caught:
            read_scan(data)
        assert str(caught.value).startswith(sentence)


def test_frames_without_a_place_are_refused_truly() -> None:
    for name in ("PlanePositionSequence", "SegmentIdentificationSequence"):
        made = seg(masks())
        for group in made.PerFrameFunctionalGroupsSequence:
            del group[name]
        with pytest.raises(BadScan, match="does not say"):
            read_scan(file_of(made))
    made = seg(masks())
    made.PerFrameFunctionalGroupsSequence[3].PlanePositionSequence[0].ImagePositionPatient[2] += 0.9
    with pytest.raises(BadScan, match="unevenly spaced"):
        read_scan(file_of(made))
    made = seg(masks(), shares=False)
    orientation = Dataset()
    orientation.ImageOrientationPatient = [0, 1, 0, 0, 0, 1]
    made.PerFrameFunctionalGroupsSequence[3].PlaneOrientationSequence = [orientation]
    with pytest.raises(BadScan, match="do not lie in parallel"):
        read_scan(file_of(made))


def zipped(**files: bytes) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, content in files.items():
            packed.writestr(name.replace("__", "/").replace("_dot_", "."), content)
    return stream.getvalue()


def test_a_zip_has_its_label_map_whatever_it_is_called() -> None:
    import gzip

    from helpers.label_maps import body_labels

    segmentation, image = file_of(seg(masks())), other("1.2.840.10008.5.1.4.1.1.4", "MR", Rows=4, Columns=4)
    plain = nifti(body_labels())
    for data in (
        zipped(a_dot_nii_dot_gz=gzip.compress(plain)),
        zipped(IM000001=segmentation),
        zipped(DICOM__1=image, DICOM__2=image, DICOM__3=segmentation, README_dot_txt=b"Hello"),
        gzip.compress(zipped(a_dot_dcm=segmentation)),
        gzip.compress(segmentation),
    ):
        check(read_scan(data))
    structures = other("1.2.840.10008.5.1.4.1.1.481.3", "RTSTRUCT")
    for data, sentence in (
        (zipped(a=plain, b=segmentation), "This zip holds 2 label maps or volumes"),
        (zipped(a=image, b=structures), "This is a structure set"),
        (zipped(a=image), "This DICOM file holds neither an image"),
        (zipped(a_dot_seg_dot_nrrd=b"NRRD0005\n"), "The header of this NRRD file is damaged"),
        (zipped(a_dot_txt=b"Hello"), "This zip holds no mesh and no volume"),
        (zipped(a_dot_ply=b"ply\n", b_dot_dcm=segmentation), "This zip holds a mesh and a volume"),
    ):
        with pytest.raises(BadScan) as caught:
            read_scan(data)
        assert str(caught.value).startswith(sentence)


def test_what_unpacks_without_end_is_refused_before_it_is_unpacked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dicom_seg, "DICOM_BYTES", 2_000_000)
    made = seg(masks())
    header = file_of(made, DeflatedExplicitVRLittleEndian)
    start = 132 + 12 + int.from_bytes(header[140:144], "little")
    packer = zlib.compressobj(9, zlib.DEFLATED, -zlib.MAX_WBITS)
    bomb = header[:start] + packer.compress(bytes(20_000_000)) + packer.flush()
    with pytest.raises(TooLarge, match="unpacks to more than the"):
        read_scan(bomb)
    monkeypatch.setattr(dicom_seg, "DICOM_FRAMES", 50)
    with pytest.raises(TooLarge, match="frames of 60 x 130 pixels, more than is read"):
        read_scan(file_of(made))
    monkeypatch.setattr(dicom_seg, "DICOM_ITEMS", 50)
    with pytest.raises(TooLarge, match="more than the 50 entries allowed"):
        read_scan(file_of(made))
    monkeypatch.setattr(dicom_seg, "DICOM_ELEMENTS", 5)
    monkeypatch.setattr(dicom_seg, "DICOM_ITEMS", 5000)
    with pytest.raises(TooLarge, match="more than the 5 elements allowed"):
        read_scan(file_of(made))
