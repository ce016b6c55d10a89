"""DICOM files made to do harm are refused by what their headers say, before anything of that size is allocated."""

import io
import struct
import tracemalloc
import zipfile
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from helpers.chest_image import chest_image
from helpers.dicom_files import Series, enhanced, file_of, files, foldered, slices, zipped
from PIL import Image
from pydicom.dataset import Dataset
from pydicom.encaps import encapsulate
from pydicom.uid import JPEG2000Lossless, JPEGLosslessSV1, RLELossless

from breastrig.core.errors import BadInput, BadScan, TooLarge
from breastrig.scan.images import dicom_files, dicom_headers, dicom_series
from breastrig.scan.images.dicom_images import DicomImage, image_in, image_of_file
from breastrig.scan.read import read_scan
from breastrig.scan.volumes.answers import NOTHING_SAID

MOST = 60_000_000  # bytes that reading such a file may need; the whole chest has 0.5 MB


def refused(data: bytes | Path, kind: type[BadInput] = BadScan) -> str:
    tracemalloc.start()
    try:
        with pytest.raises(BadInput) as caught:
            read_scan(data)
        assert tracemalloc.get_traced_memory()[1] < MOST
    finally:
        tracemalloc.stop()
    assert isinstance(caught.value, kind)
    return str(caught.value)


def huge(made: Dataset, at: int) -> None:
    made.Rows = made.Columns = 60_000


def test_huge_matrices() -> None:
    assert "at most 4096 x 4096 are read" in refused(zipped(files(Series(chest_image(), change=huge))), TooLarge)
    assert "at most 4096 x 4096 are read" in refused(file_of(enhanced(Series(chest_image(), change=huge))), TooLarge)


def test_large_matrices_that_lie_about_their_pixels() -> None:
    def large(made: Dataset, at: int) -> None:
        made.Rows = made.Columns = 4096

    assert "voxels allowed" in refused(zipped(files(Series(chest_image(), change=large))), TooLarge)

    def larger(made: Dataset, at: int) -> None:
        made.Rows = 200

    assert "damaged or cut off" in refused(zipped(files(Series(chest_image(), change=larger))))


def test_millions_of_frames() -> None:
    def many(made: Dataset, at: int) -> None:
        made.NumberOfFrames = 2_000_000_000

    assert "frames" in refused(file_of(enhanced(Series(chest_image(), change=many))), TooLarge)


def test_lengths_that_lie() -> None:
    made = file_of(slices(Series(chest_image()))[0])
    at = made.index(struct.pack("<HH", 0x0020, 0x0032))
    for length in (0, 1, 0xFFFE):
        lying = made[: at + 6] + struct.pack("<H", length) + made[at + 8 :]
        content = {name: lying if data == made else data for name, data in files(Series(chest_image())).items()}
        found = image_in(zipped(content), NOTHING_SAID)
        assert isinstance(found, DicomImage)
        assert found.image.values.shape[2] == 39
    pixels = made.index(struct.pack("<HH", 0x7FE0, 0x0010))
    for length in (0xFFFFFFF0, 0x7FFFFFFF):
        lying = made[: pixels + 8] + struct.pack("<I", length) + made[pixels + 12 :]
        assert "damaged or cut off" in refused(lying) or "fewer than 8" in refused(lying)


def test_every_cut_is_one_sentence() -> None:
    whole = file_of(enhanced(Series(chest_image())))
    for cut in (100, 132, 140, 200, 400, 1000, 5000, 20_000, len(whole) - 1):
        with pytest.raises(BadInput) as caught:
            read_scan(whole[:cut])
        assert str(caught.value).endswith(".")
        assert "\n" not in str(caught.value)


def test_bytes_changed_by_chance_are_one_sentence_or_an_image() -> None:
    whole = np.frombuffer(file_of(enhanced(Series(chest_image()))), np.uint8)
    head = bytes(whole).index(struct.pack("<HH", 0x7FE0, 0x0010))
    rng = np.random.default_rng(4)
    for _ in range(60):
        changed = whole.copy()
        changed[rng.integers(0, head, 6)] = rng.integers(0, 256, 6)
        with suppress(BadInput):
            image_of_file(changed.tobytes(), NOTHING_SAID)


def test_ten_thousand_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tiny = bytes(128) + b"DICM"
    assert dicom_files.IMAGE_FILES == 10_000
    monkeypatch.setattr(dicom_files, "IMAGE_FILES", 100)
    assert "More than the 10,000 files" in refused(zipped({f"{at}": tiny for at in range(101)}), TooLarge)
    assert "More than the" in refused(foldered({f"{at}": tiny for at in range(101)}, tmp_path / "many"), TooLarge)
    assert "More than the" in refused(foldered({f"{at}": b"" for at in range(201)}, tmp_path / "others"), TooLarge)
    monkeypatch.setattr(dicom_files, "IMAGE_FOLDERS", 5)
    deep = {"/".join(["a"] * depth) + "/x": b"" for depth in range(1, 9)}
    assert "More than the" in refused(foldered(deep, tmp_path / "deep"), TooLarge)


def test_zip_bombs(monkeypatch: pytest.MonkeyPatch) -> None:
    made = slices(Series(chest_image()))[0]
    made.PixelData = bytes(80_000_000)  # more than MOST
    bomb = zipped({"a": file_of(made)}, zipfile.ZIP_DEFLATED)
    assert len(bomb) < 400_000
    assert "packed more than 100 times" in refused(bomb, TooLarge)
    monkeypatch.setattr(dicom_files, "IMAGE_BYTES", 100_000)
    assert "DICOM files there have more than" in refused(zipped(files(Series(chest_image()))), TooLarge)
    monkeypatch.setattr(dicom_files, "IMAGE_ZIP_BYTES", 1000)
    assert "MB allowed" in refused(zipped(files(Series(chest_image()))), TooLarge)
    monkeypatch.undo()
    monkeypatch.setattr(dicom_files, "IMAGE_FILE_BYTES", 1000)
    assert "A DICOM file has more than the" in refused(zipped(files(Series(chest_image()))), TooLarge)


def test_far_too_many_groups_elements_and_items(monkeypatch: pytest.MonkeyPatch) -> None:
    def alone(made: Dataset, at: int) -> None:
        made.EchoTime = float(at)

    content = zipped(files(Series(chest_image(), change=alone)))
    assert "fewer than 8 slices" in refused(content)
    monkeypatch.setattr(dicom_series, "IMAGE_STACKS", 3)
    assert "far too many groups" in refused(content, TooLarge)
    monkeypatch.undo()
    monkeypatch.setattr(dicom_headers, "DICOM_ELEMENTS", 5)
    assert "elements allowed" in refused(content, TooLarge)
    monkeypatch.undo()
    monkeypatch.setattr(dicom_headers, "DICOM_ITEMS", 10)
    assert "entries allowed" in refused(file_of(enhanced(Series(chest_image()))), TooLarge)


def compressed(syntax: str, frames: list[bytes]) -> dict[str, bytes]:
    made = slices(Series(chest_image()))
    for each, packed in zip(made, frames, strict=True):
        each.PixelData = encapsulate([packed])
        each["PixelData"].is_undefined_length = True
    return {str(at): file_of(each, syntax) for at, each in enumerate(made)}


def test_compressed_pixels_are_read_or_said() -> None:
    from pydicom.pixels.encoders import RLELosslessEncoder

    values = chest_image().values
    facts = {"samples_per_pixel": 1, "photometric_interpretation": "MONOCHROME2", "bits_allocated": 16}
    facts |= {
        "bits_stored": 16,
        "pixel_representation": 0,
        "number_of_frames": 1,
        "rows": values.shape[1],
        "columns": values.shape[0],
    }
    packed = [
        RLELosslessEncoder.encode(np.ascontiguousarray(values[:, :, at].T), **facts) for at in range(values.shape[2])
    ]
    found = image_in(zipped(compressed(RLELossless, packed)), NOTHING_SAID)
    assert isinstance(found, DicomImage)
    np.testing.assert_array_equal(found.image.values, values)
    packed = []
    for at in range(values.shape[2]):
        stream = io.BytesIO()
        Image.fromarray(np.ascontiguousarray(values[:, :, at].T)).save(stream, "JPEG2000", no_jp2=True)
        packed.append(stream.getvalue())
    found = image_in(zipped(compressed(JPEG2000Lossless, packed)), NOTHING_SAID)
    assert isinstance(found, DicomImage)
    np.testing.assert_array_equal(found.image.values, values)
    junk = [b"\xff\xd8\xff\xc3" + bytes(200)] * values.shape[2]
    sentence = refused(zipped(compressed(JPEGLosslessSV1, junk)))
    assert sentence.startswith("The pixels of these DICOM images are compressed in a way (JPEG Lossless")
    assert "install python-gdcm" in sentence or "damaged" in sentence
    bomb = struct.pack("<16L", 2, 64, 64 + 200_000, *[0] * 13) + b"\x81\x00" * 200_000
    assert "damaged or cut off" in refused(zipped(compressed(RLELossless, [bomb] * values.shape[2])))
