"""Several series are asked about, through every door, and the answer is the same each time."""

import base64
import io
import pickle
from pathlib import Path

import numpy as np
import pytest
from helpers.chest_image import SHAPE, SIZES, chest_image
from helpers.dicom_files import SECRET, Series, enhanced, file_of, files, foldered, lesion_seg, zipped
from PIL import Image

import breastrig
from breastrig.batch.manifest import read_manifest
from breastrig.batch.run import scan_bytes
from breastrig.cli.main import main
from breastrig.core.errors import BadInput, NeedsAnswer
from breastrig.fitting.prepare_scan import prepared_scan
from breastrig.rig.model import Rig
from breastrig.scan.images.dicom_images import DicomImage, image_in
from breastrig.scan.read import read_scan
from breastrig.scan.stored_scan import STORED, write_stored
from breastrig.scan.volumes.answers import NOTHING_SAID, checked_answers

TWO = (Series(chest_image(), "t1 fett", 3), Series(chest_image(), "t2 stir", 2))


@pytest.fixture(scope="module")
def content() -> dict[str, bytes]:
    return files(*TWO)


def asked(source: bytes | Path) -> list[dict[str, str]]:
    with pytest.raises(NeedsAnswer) as caught:
        read_scan(source)
    again = pickle.loads(pickle.dumps(caught.value))  # as it comes from the process that reads
    assert (str(again), again.question) == (str(caught.value), caught.value.question)
    assert caught.value.question["field"] == "series"
    found: list[dict[str, str]] = caught.value.question["choices"]
    return found


def test_choices_say_what_each_series_is(content: dict[str, bytes], tmp_path: Path) -> None:
    first, second = asked(zipped(content))
    assert first["text"] == 'axial, 40 slices 4 mm apart, 94 x 60 pixels of 3 x 3.2 mm, "t2 stir"'
    assert second["text"].endswith('"t1 fett"')
    for each in (first, second):
        with Image.open(io.BytesIO(base64.b64decode(each["picture"].split(",", 1)[1]))) as picture:
            assert (picture.format, picture.mode) == ("PNG", "L")
            assert max(picture.size) == 160
            assert picture.width / picture.height == pytest.approx(SHAPE[0] * SIZES[0] / SHAPE[1] / SIZES[1], abs=0.02)
        assert len(each["value"]) == 8
    assert asked(foldered(content, tmp_path)) == [first, second]
    assert asked(zipped(dict(reversed(content.items())))) == [first, second]


def test_python_and_what_is_kept(content: dict[str, bytes], tmp_path: Path) -> None:
    folder = foldered(content, tmp_path / "mri")
    _, chosen = asked(folder)
    scan = breastrig.read_scan(folder, series=chosen["value"])
    assert (scan.unit, scan.in_metres.from_image, scan.in_metres.in_patient_frame) == ("mm", True, True)
    of_zip = breastrig.read_scan(zipped(content), series=chosen["value"].upper())
    np.testing.assert_array_equal(of_zip.vertices, scan.vertices)
    assert scan.in_metres.image is not None
    np.testing.assert_allclose(scan.in_metres.image.affine, chest_image().affine, atol=1e-6)
    assert prepared_scan(scan.in_metres, "auto").frame.stance == "prone"
    write_stored(scan.in_metres, tmp_path / "kept")
    again = read_scan(tmp_path / "kept", STORED)
    assert (again.from_image, again.in_patient_frame, again.sha256) == (True, True, scan.sha256)
    assert "An image says where the patient's front" in prepared_scan(again, "auto").frame.reason
    kept = (tmp_path / "kept").read_bytes()
    for word in ("t1 fett", SECRET, "mri"):
        assert word.encode() not in kept
    with pytest.raises(BadInput, match="series are for those alone"):
        breastrig.read_scan(b"ply\nformat ascii 1.0\nend_header\n", series="0")


def test_one_file_of_all_slices_needs_no_zip() -> None:
    scan = read_scan(file_of(enhanced(TWO[0])))
    assert scan.from_image
    with pytest.raises(BadInput, match="leave units out"):
        read_scan(file_of(enhanced(TWO[0])), units="cm")


def test_the_command_line_names_the_option(
    content: dict[str, bytes], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = foldered(content, tmp_path / "mri")
    first, _ = asked(folder)
    assert main(["fit", str(folder), "-o", str(tmp_path / "out")]) == 2
    assert f"--series {first['value']} (axial, 40 slices" in capsys.readouterr().err
    case = str(tmp_path / "case")
    assert main(["case", "create", case]) == 0
    assert main(["case", "add", case, str(folder), "--series", first["value"]]) == 0
    for file in Path(case).rglob("*"):
        if file.is_file():
            assert not any(word.encode() in file.read_bytes() for word in ("t2 stir", SECRET))
    assert main(["case", "add", case, str(folder), "--series", first["value"]]) == 2
    assert "--again" in capsys.readouterr().err


def test_of_many_series_a_sentence_names_the_first_and_the_command_line_lists_all(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    many = files(*(Series(chest_image(), f"t1 {number}", number) for number in range(1, 8)))
    folder = foldered(many, tmp_path / "mri")
    with pytest.raises(NeedsAnswer) as caught:
        read_scan(folder)
    values = [each["value"] for each in caught.value.question["choices"]]
    assert [value in str(caught.value) for value in values] == [True] * 4 + [False] * 3
    assert str(caught.value).endswith(" or one of 3 more, which breastrig fit lists.")
    assert main(["fit", str(folder), "-o", str(tmp_path / "out")]) == 2
    first, *lines = capsys.readouterr().err.splitlines()
    assert first == "breastrig: These DICOM files hold several series that show a volume; say which it is:"
    assert [line.partition(" (")[0] for line in lines] == [f"  --series {value}" for value in values]


def test_a_batch_has_a_column(content: dict[str, bytes], tmp_path: Path, rig: Rig) -> None:
    folder = foldered(content, tmp_path / "mri")
    _, chosen = asked(folder)
    (tmp_path / "m.csv").write_text(f"scan,series\nmri,{chosen['value']}\n")
    (row,) = read_manifest(tmp_path / "m.csv", rig, tmp_path / "out")
    assert row.answers.series == chosen["value"]
    packed = scan_bytes(row.scan)
    assert packed == scan_bytes(row.scan)


def test_a_segmentation_beside_the_image_is_handed_on() -> None:
    lesion = np.zeros(SHAPE, np.bool_)
    lesion[60:64, 20:24, 18:21] = True
    seg = lesion_seg(TWO[0], lesion)
    for answers in (NOTHING_SAID, checked_answers(None, {1: "lesion"})):
        found = image_in(zipped(files(TWO[0]) | {"SEG": seg}), answers)
        assert isinstance(found, DicomImage)
        assert found.segmentations == (seg,)
