"""MR images as DICOM: each slice lies where its header says, whatever the files are called."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.chest_image import SHAPE, SIZES, chest_image
from helpers.dicom_files import NAME, SECRET, Series, file_of, files, foldered, slices, uid, zipped
from pydicom.dataset import Dataset
from pydicom.uid import DeflatedExplicitVRLittleEndian, ExplicitVRBigEndian, ImplicitVRLittleEndian

from breastrig.core.errors import BadInput, BadScan, NeedsAnswer
from breastrig.scan.images.dicom_images import DicomImage, image_in
from breastrig.scan.images.image import ImageVolume
from breastrig.scan.volumes.answers import NOTHING_SAID, VolumeAnswers
from breastrig.scan.volumes.volume import Gap, frame_digest

EXACT = 1e-3  # mm
Change = Callable[[Dataset, int], None]


def read(content: dict[str, bytes], series: str | None = None) -> ImageVolume:
    found = image_in(zipped(content), VolumeAnswers(series=series) if series else NOTHING_SAID)
    assert isinstance(found, DicomImage)
    return found.image


def of(change: Change, **more: object) -> ImageVolume:
    return read(files(Series(chest_image(), change=change, **more)))


def refusal(content: dict[str, bytes]) -> str:
    with pytest.raises(BadInput) as caught:
        read(content)
    return str(caught.value)


def choices(content: dict[str, bytes]) -> dict[str, str]:
    """Text by value."""
    with pytest.raises(NeedsAnswer) as caught:
        read(content)
    assert caught.value.question["field"] == "series"
    return {each["value"]: each["text"] for each in caught.value.question["choices"]}


def check(image: ImageVolume, affine: np.ndarray | None = None, values: np.ndarray | None = None) -> None:
    """The places of the corners, and all values."""
    expected = chest_image().values if values is None else values
    assert image.values.shape == expected.shape
    ends = np.array(np.meshgrid(*[(0, size - 1) for size in expected.shape], [1])).reshape(4, -1)
    true = chest_image().affine if affine is None else affine
    np.testing.assert_allclose(image.affine @ ends, true @ ends, atol=EXACT)
    np.testing.assert_array_equal(image.values, expected)


@pytest.mark.parametrize(
    "syntax", [ImplicitVRLittleEndian, DeflatedExplicitVRLittleEndian, ExplicitVRBigEndian], ids=lambda each: each.name
)
def test_transfer_syntaxes(syntax: str) -> None:
    if syntax == ExplicitVRBigEndian:
        image = replace(chest_image(), values=chest_image().values.byteswap())  # of words, as the helper writes them
        check(read(files(Series(image, syntax=syntax))))
    else:
        check(read(files(Series(chest_image(), syntax=syntax))))


def test_files_without_preamble_and_frames_of_one_file() -> None:
    check(read(files(Series(chest_image()))))
    check(read(files(Series(chest_image(), preamble=False, syntax=ImplicitVRLittleEndian))))
    check(read(files(Series(chest_image()), many_frames=True)))
    assert read(files(Series(chest_image()))).frame == frame_digest(uid("frame"))


@pytest.mark.parametrize("plane", ["sagittal", "oblique"])
def test_planes_that_are_not_axial(plane: str) -> None:
    turn = np.eye(4)
    if plane == "sagittal":
        turn[:3, :3] = [[0, 0, -1], [1, 0, 0], [0, -1, 0]]
    else:
        turn[:3, :3] = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
        turn[:3, :3] *= np.linalg.det(turn[:3, :3])
    affine = turn @ chest_image().affine
    check(read(files(Series(replace(chest_image(), affine=affine)))), affine)


def test_a_missing_slice_is_filled_and_said_and_nothing_is_squeezed() -> None:
    image = read(files(Series(chest_image(), left_out=[20])))
    mean = 0.5 * (chest_image().values[:, :, 19].astype(float) + chest_image().values[:, :, 21])
    np.testing.assert_allclose(image.values[:, :, 20], mean, atol=1.0)
    values = chest_image().values.copy()
    values[:, :, 20] = image.values[:, :, 20]
    check(image, values=values)
    assert image.gaps == ()
    assert image.notes == ("A slice is missing between others; the mean of the neighbours was taken there.",)


def test_several_missing_slices_stay_a_gap() -> None:
    image = read(files(Series(chest_image(), left_out=[20, 21, 22])))
    assert image.gaps == (Gap(2, 20, 22),)
    values = chest_image().values.copy()
    values[:, :, 20:23] = 0
    check(image, values=values)
    assert "3 slices are missing between others" in image.notes[0]
    assert "unevenly spaced" in refusal(files(Series(chest_image(), left_out=range(4, 28))))


def test_a_tilt_is_in_the_places() -> None:
    affine = chest_image().affine.copy()
    affine[1, 2] = np.tan(np.radians(17.0)) * SIZES[2]
    image = read(files(Series(replace(chest_image(), affine=affine))))
    check(image, affine)
    assert "lean by 17 degrees" in image.notes[0]


def test_two_breasts_apart_are_two_volumes() -> None:
    def apart(made: Dataset, at: int) -> None:
        x, y, z = made.ImagePositionPatient
        made.ImagePositionPatient = [x, y, float(z) + (41.5 if at >= 20 else 0.0)]

    content = files(Series(chest_image(), change=apart))
    first, second = choices(content)
    moved = chest_image().affine.copy()
    check(read(content, first), values=chest_image().values[:, :, :20])
    moved[2, 3] += 20 * SIZES[2] + 41.5
    check(read(content, second), moved, chest_image().values[:, :, 20:])


def test_frames_of_one_file_in_several_phases() -> None:
    """Of four dimensions: each time is a volume of its own."""

    def twice(made: Dataset, at: int) -> None:
        own = list(made.PerFrameFunctionalGroupsSequence)
        for number, groups in enumerate(own):
            groups.FrameContentSequence[0].TemporalPositionIndex = 1 + number % 2
            groups.PlanePositionSequence[0].ImagePositionPatient = list(
                chest_image().affine[:3, 3] + number // 2 * chest_image().affine[:3, 2]
            )

    both = np.repeat(chest_image().values, 2, axis=2)
    both[:, :, 1::2] += 500
    content = files(Series(replace(chest_image(), values=both), change=twice), many_frames=True)
    first, second = choices(content)
    check(read(content, first))
    check(read(content, second), values=chest_image().values + 500)


def test_unevenly_spaced_slices_are_refused() -> None:
    def wider(made: Dataset, at: int) -> None:
        made.ImagePositionPatient = [
            *made.ImagePositionPatient[:2],
            60.0 + 4.0 * at + (0.4 * (at - 20) if at > 20 else 0),
        ]

    def off(made: Dataset, at: int) -> None:
        if at == 11:
            made.ImagePositionPatient = [float(made.ImagePositionPatient[0]) + 5.0, *made.ImagePositionPatient[1:]]

    for change in (wider, off):
        assert "unevenly spaced" in refusal(files(Series(chest_image(), change=change)))


@pytest.mark.parametrize("told_by", ["temporal", "acquisition", "echo", "kind"])
def test_two_phases_of_one_series_never_interleave(told_by: str) -> None:
    def phase(number: int) -> Change:
        def change(made: Dataset, at: int) -> None:
            made.SOPInstanceUID = uid("phase", number, at)
            made.SeriesInstanceUID = uid("both")
            made.InstanceNumber = 2 * at + number
            made.TriggerTime = 7.0 * (2 * at + number)  # of each slice: tells nothing
            if told_by == "temporal":
                made.TemporalPositionIdentifier = number
            elif told_by == "acquisition":
                made.AcquisitionNumber = number
            elif told_by == "echo":
                made.EchoTime = 1.2 * number
            else:
                made.ImageType = ["DERIVED", "PRIMARY", "DIXON", "WF"[number - 1]]

        return change

    later = replace(chest_image(), values=chest_image().values + 1000)
    content = files(Series(chest_image(), change=phase(1)), Series(later, change=phase(2)))
    asked = choices(content)
    first, second = asked
    assert "volume 1 of 2 of this series" in asked[first]
    check(read(content, first))
    check(read(content, second), values=later.values)


def test_pictures_of_one_place_that_nothing_tells_apart_are_refused() -> None:
    def same_series(made: Dataset, at: int) -> None:
        made.SeriesInstanceUID, made.SOPInstanceUID = uid("one"), uid(made.SeriesDescription, at, "x")

    content = files(Series(chest_image(), change=same_series), Series(chest_image(), "t2", change=same_series))
    assert "Several DICOM images of this series lie on one place" in refusal(content)


def test_copies_are_read_once() -> None:
    content = files(Series(chest_image()))
    image = read(content | {f"copy/{name}": data for name, data in content.items()})
    check(image)
    assert image.notes == ("40 DICOM images lay there twice and were read once.",)


def test_two_pixel_spacings_matrices_and_directions_are_volumes_of_their_own() -> None:
    def both(spacing: float) -> Change:
        def change(made: Dataset, at: int) -> None:
            made.SeriesInstanceUID, made.SOPInstanceUID = uid("one"), uid(spacing, at)
            made.PixelSpacing = [spacing, spacing]

        return change

    content = files(Series(chest_image(), change=both(3.0)), Series(chest_image(), change=both(2.0)))
    for value, text in choices(content).items():
        size = 3.0 if "of 3 x 3 mm" in text else 2.0
        np.testing.assert_allclose(np.diag(read(content, value).affine)[:2], size, atol=1e-9)


def test_localizers_few_slices_and_other_files_are_no_choices() -> None:
    def localizer(made: Dataset, at: int) -> None:
        made.ImageType = ["ORIGINAL", "PRIMARY", "LOCALIZER"]

    def small(made: Dataset, at: int) -> None:
        turn = [[1, 0, 0, 0, 1, 0], [0, 1, 0, 0, 0, -1], [1, 0, 0, 0, 0, -1]][at % 3]
        made.ImageOrientationPatient = [float(each) for each in turn]

    def report(made: Dataset, at: int) -> None:
        made.SOPClassUID, made.Modality = "1.2.840.10008.5.1.4.1.1.88.11", "SR"
        del made.PixelData

    def colour(made: Dataset, at: int) -> None:
        made.SOPClassUID, made.Modality, made.SamplesPerPixel = "1.2.840.10008.5.1.4.1.1.7", "OT", 3

    short = replace(chest_image(), values=chest_image().values[:, :, :7])
    content = files(
        Series(chest_image()),
        Series(chest_image(), "localizer", change=localizer),
        Series(replace(chest_image(), values=chest_image().values[:, :, :15]), "three planes", change=small),
        Series(short, "few"),
        Series(short, "report", change=report),
        Series(short, "secondary", change=colour),
    )
    check(read(content | {"DICOMDIR": b"no matter", "README.TXT": b"Hello"}))
    assert "fewer than 8 slices" in refusal(files(Series(short)))


def test_scales_differ_from_slice_to_slice() -> None:
    def scaled(made: Dataset, at: int) -> None:
        made.RescaleSlope, made.RescaleIntercept = 1.0 + 0.5 * (at % 2), float(at)

    values = chest_image().values * (1.0 + 0.5 * (np.arange(SHAPE[2]) % 2)) + np.arange(SHAPE[2])
    check(of(scaled), values=values.astype(np.float32))


def test_inverted_and_signed_pixels() -> None:
    def inverted(made: Dataset, at: int) -> None:
        made.PhotometricInterpretation = "MONOCHROME1"

    check(of(inverted), values=int(chest_image().values.max()) - chest_image().values.astype(np.int32))
    signed = chest_image().values.astype(np.int16) - 400
    check(read(files(Series(replace(chest_image(), values=signed)))), values=signed)


def test_bits_beside_the_stored_ones_are_no_pixels() -> None:
    def overlay(made: Dataset, at: int) -> None:
        made.BitsStored, made.HighBit = 12, 11
        made.PixelData = (np.frombuffer(made.PixelData, "<u2") | 0x8000).tobytes()

    check(of(overlay))

    def negative(made: Dataset, at: int) -> None:
        made.BitsStored, made.HighBit = 12, 11
        made.PixelData = (np.frombuffer(made.PixelData, "<i2") & 0x0FFF).astype("<i2").tobytes()

    signed = chest_image().values.astype(np.int16) - 400
    check(read(files(Series(replace(chest_image(), values=signed), change=negative))), values=signed)


def test_damaged_files_are_left_out_and_said() -> None:
    content = files(Series(chest_image()))
    one = file_of(slices(Series(chest_image()))[20])
    (name,) = [name for name, data in content.items() if data == one]
    image = read(content | {name: content[name][:-3000]})
    assert image.notes == (
        "A slice is missing between others; the mean of the neighbours was taken there.",
        "1 of the DICOM files there is damaged or cut off and was left out.",
    )


def test_what_is_no_mr_image_is_said_truly() -> None:
    def ct(made: Dataset, at: int) -> None:
        made.Modality = "CT"

    def placeless(made: Dataset, at: int) -> None:
        del made.ImagePositionPatient

    def colour(made: Dataset, at: int) -> None:
        made.SamplesPerPixel, made.PhotometricInterpretation = 3, "RGB"

    for change, words in (
        (ct, "are no MR images (their modality is CT)"),
        (placeless, "do not say where they lie"),
        (colour, "are in colour"),
    ):
        assert words in refusal(files(Series(chest_image(), change=change)))


def test_an_answer_that_does_not_fit_is_one_sentence() -> None:
    content = zipped(files(Series(chest_image())))
    with pytest.raises(BadInput, match="There is no such series in these DICOM files; they have"):
        image_in(content, VolumeAnswers(series="nonsense"))
    with pytest.raises(BadInput, match="leave frame and segments out"):
        image_in(content, VolumeAnswers("RAS"))


def test_no_word_of_the_headers_is_kept(tmp_path: Path) -> None:
    """Only the description is shown while choosing; in what is kept there is nothing."""
    import pickle

    for many in (False, True):
        found = image_in(zipped(files(Series(chest_image(), "Beschreibung"), many_frames=many)), NOTHING_SAID)
        kept = pickle.dumps(found)
        for word in (
            NAME,
            SECRET,
            "Beschreibung",
            "19700101",
            "20260102",
            "terfrau",
            uid("frame"),
            uid("Beschreibung"),
        ):
            assert word.encode() not in kept
            assert word.encode("latin-1", "replace") not in kept


def test_no_word_of_the_headers_is_logged(caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]) -> None:
    """pydicom warns of values that break its rules, and repeats them."""
    right, wrong = str(uid("t1", "series")).encode(), b"Geheim^Wort"
    content = {
        name: data.replace(right, wrong.ljust(len(right), b"x")) for name, data in files(Series(chest_image())).items()
    }
    check(read(content))
    assert caplog.records == []
    assert capfd.readouterr() == ("", "")


def test_a_folder_is_read_with_all_below_it_and_no_link_is_followed(tmp_path: Path) -> None:
    content = files(Series(chest_image(), left_out=[39]))
    outside = tmp_path / "outside.dcm"
    outside.write_bytes(file_of(slices(Series(chest_image()))[39]))
    folder = foldered(content, tmp_path / "mri")
    (folder / "link.dcm").symlink_to(outside)
    (folder / "loop").symlink_to(folder)
    found = image_in(folder, NOTHING_SAID)
    assert isinstance(found, DicomImage)
    check(found.image, values=chest_image().values[:, :, :39])
    with pytest.raises(BadScan, match="This folder holds no DICOM files"):
        image_in(foldered({"a.txt": b"Hello"}, tmp_path / "empty"), NOTHING_SAID)
