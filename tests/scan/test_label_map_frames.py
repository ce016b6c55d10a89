"""Where a label map lies: never guessed, asked where its file does not say it or says it twice."""

import base64
import io
import pickle
from pathlib import Path

import numpy as np
import pytest
from helpers.label_maps import (
    BODY_WORDS,
    LESION,
    LOW,
    PLAIN,
    RADIUS,
    SIZES,
    body_labels,
    dicom_segmentation,
    file_of,
    masks,
    nifti,
    placed_nifti,
    seg,
    to_ras,
)
from PIL import Image

import breastrig
from breastrig.cli.main import main
from breastrig.core.errors import BadInput, NeedsAnswer
from breastrig.scan.read import read_scan
from breastrig.scan.volumes.answers import checked_answers

MIRROR = np.diag([-1.0, 1.0, 1.0, 1.0])


def unplaced(labels: np.ndarray) -> bytes:
    """Without any word about where its voxels lie."""
    return placed_nifti(labels, (np.diag([*SIZES, 1.0]), 0), (np.diag([*SIZES, 1.0]), 0))


def question_of(data: bytes) -> dict[str, dict[str, object]]:
    """The choices by their values."""
    with pytest.raises(NeedsAnswer) as caught:
        read_scan(data)
    again = pickle.loads(pickle.dumps(caught.value))  # as it comes from the process that reads
    assert (str(again), again.question) == (str(caught.value), caught.value.question)
    assert caught.value.question["field"] == "frame"
    return {each["value"]: each for each in caught.value.question["choices"]}


def test_the_side_that_no_header_names_is_asked() -> None:
    """The same bytes lie left or right, whichever a library takes by itself."""
    labels = body_labels()[::-1, ::-1]  # stored to the right and to the front, as most are
    choices = question_of(unplaced(np.asfortranarray(labels)))
    assert list(choices)[:4] == ["RAS", "LAS", "RAI", "LAI"]
    assert {value[1] for value in choices} == {"A"}  # the front has air, so that is known
    for value, side, up in (("LAS", "R", 1), ("RAI", "L", -1)):
        lesions = choices[value]["lesions"]
        assert isinstance(lesions, list)
        (shown,) = lesions
        assert (shown["name"], shown["side"]) == ("Lesion 1", side)
        middle = LOW + 0.5 * SIZES * (np.array(labels.shape) - 1)
        x = 2.0 * (LESION[0] - middle[0]) / (SIZES[0] * (labels.shape[0] - 1))
        assert shown["x"] == pytest.approx(x if side == "L" else -x, abs=0.01)
        y = (LESION[2] - LOW[2]) / (SIZES[2] * (labels.shape[2] - 1))
        assert shown["y"] == pytest.approx(y if up > 0 else 1.0 - y, abs=0.01)
        scan = read_scan(unplaced(labels), answers=checked_answers(value))
        (lesion,) = scan.lesions
        found = 1e3 * lesion.center[0]
        assert found == pytest.approx((LESION - middle)[0] * (1.0 if side == "L" else -1.0), abs=0.5)
        assert any("was said by a person" in note for note in scan.notes)


def test_a_choice_is_shown_with_a_picture_as_one_who_faces_the_patient_sees_it() -> None:
    choices = question_of(unplaced(np.asfortranarray(body_labels()[::-1, ::-1])))
    red = {}
    for value in ("RAS", "LAS"):
        start, _, content = str(choices[value]["picture"]).partition(",")
        assert start == "data:image/png;base64"
        pixels = np.asarray(Image.open(io.BytesIO(base64.b64decode(content))).convert("RGB")).astype(int)
        marked = (pixels[..., 0] > 200) & (pixels[..., 1] < 100)
        red[value] = np.flatnonzero(marked.any(axis=0)).mean() / pixels.shape[1]
    assert red["RAS"] > 0.6  # the patient's left is at the right
    assert red["LAS"] < 0.4


@pytest.mark.parametrize(("order", "front"), [((0, 1, 2), 1), ((1, 2, 0), 0), ((2, 0, 1), 2)])
def test_any_order_of_axes_is_asked_with_the_air_in_front(order: tuple[int, int, int], front: int) -> None:
    labels = np.asfortranarray(np.transpose(body_labels()[::2, ::2], order))
    choices = question_of(unplaced(labels))
    assert len(choices) == 8
    assert all(value[front] == "P" for value in choices)
    sides = {shown["side"] for each in choices.values() for shown in each["lesions"]}
    assert {"L", "R"} <= sides


def test_a_contradiction_of_sform_and_qform_is_asked_and_both_can_be_taken() -> None:
    true, false = to_ras(), MIRROR @ to_ras()
    for sform, qform, left in ((false, true, "qform"), (true, false, "sform")):
        data = placed_nifti(body_labels(), (sform, 2), (qform, 1))
        choices = question_of(data)
        sides = {value: [each["side"] for each in choice["lesions"]] for value, choice in choices.items()}
        assert sides == {left: ["L"], "qform" if left == "sform" else "sform": ["R"]}
        for value in choices:
            (lesion,) = read_scan(data, answers=checked_answers(value)).lesions
            side = 1.0 if value == left else -1.0
            assert 1e3 * lesion.center == pytest.approx(LESION * [side, 1.0, 1.0], abs=0.3)


@pytest.mark.parametrize(("moved", "asks"), [(0.5, False), (2.5, True)])
def test_more_than_a_voxel_between_both_is_asked(moved: float, asks: bool) -> None:
    other = to_ras()
    other[2, 3] += moved
    data = placed_nifti(body_labels(), (to_ras(), 1), (other, 1))
    if asks:
        assert set(question_of(data)) == {"sform", "qform"}
    else:
        assert read_scan(data).lesions[0].center * 1e3 == pytest.approx(LESION, abs=0.2)


@pytest.mark.parametrize("which", ["sform", "qform"])
def test_one_of_both_that_holds_alone_is_taken(which: str) -> None:
    holds, not_so = (to_ras(), 1), (MIRROR @ to_ras(), 0)
    data = placed_nifti(body_labels(), *((holds, not_so) if which == "sform" else (not_so, holds)))
    assert 1e3 * read_scan(data).lesions[0].center == pytest.approx(LESION, abs=0.2)
    assert read_scan(data, answers=checked_answers(which)).lesions
    assert read_scan(data, answers=checked_answers("LPS")).lesions  # as it lies
    with pytest.raises(BadInput, match="and not as RPS; leave frame out"):
        read_scan(data, answers=checked_answers("RPS"))


def test_answers_that_do_not_fit_are_one_sentence() -> None:
    for given in ("up", "RLS", "RASS"):
        with pytest.raises(BadInput, match="This is no frame"):
            breastrig.read_scan(nifti(body_labels()), frame=given)
    with pytest.raises(BadInput, match="so that there is no sform to be taken"):
        breastrig.read_scan(unplaced(body_labels()), frame="sform")
    with pytest.raises(BadInput, match="A DICOM segmentation says itself where it lies"):
        breastrig.read_scan(dicom_segmentation(body_labels()), frame="RAS")
    with pytest.raises(BadInput, match="frame, segments and series are for those"):
        breastrig.read_scan(b"ply\nformat ascii 1.0\nend_header\n", frame="RAS")
    assert breastrig.read_scan(unplaced(body_labels()), frame="lps").in_metres.lesions[0].radius == pytest.approx(
        1e-3 * RADIUS, abs=1e-4
    )


@pytest.mark.parametrize("command", ["fit", "landmarks"])
def test_the_command_line_names_the_option_that_answers(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "map.nii").write_bytes(unplaced(np.asfortranarray(body_labels()[::-1, ::-1])))
    out = tmp_path / ("out" if command == "fit" else "out.json")
    assert main([command, str(tmp_path / "map.nii"), "-o", str(out)]) == 2
    said = capsys.readouterr().err
    assert "does not say which side is left" in said
    assert "\n  --frame RAS (axes to right, front, head; Lesion 1 left)\n  --frame LAS" in said
    assert not out.exists()
    assert main([command, str(tmp_path / "map.nii"), "-o", str(out), "--frame", "RXS"]) == 2
    assert "This is no frame" in capsys.readouterr().err
    assert main([command, str(tmp_path / "map.nii"), "-o", str(out), "--frame", "RAS", "--segment", "9=lesion"]) == 2
    assert "There is no segment 9 in this file; it has 1, 2, 3." in capsys.readouterr().err


def test_the_terminal_shows_what_the_file_calls_its_segments(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """For development; nothing that is written has these words."""
    words = {1: BODY_WORDS, 2: ("Zoe Quixote", *PLAIN[1:])}
    (tmp_path / "IM000001").write_bytes(file_of(seg(masks(), words)))
    assert (
        main(["landmarks", str(tmp_path / "IM000001"), "-o", str(tmp_path / "out.json"), "--segment", "2=tissue"]) == 0
    )
    said = capsys.readouterr().err
    assert 'segment 2 "Zoe Quixote Tissue": tissue (Tissue 2). A person said so.' in said
    assert "Quixote" not in (tmp_path / "out.json").read_text()


@pytest.mark.parametrize(("unit", "factor"), [("mm", 1.0), ("meter", 1e-3), ("micron", 1e3)])
def test_the_unit_is_the_files_own_whatever_the_size(unit: str, factor: float) -> None:
    """One breast, 16 cm wide: its size alone would be a torso in centimetres."""
    import nibabel

    part = body_labels()[65:, 5:]
    affine = to_ras(LOW + SIZES * [65, 5, 0])
    affine[:3] *= factor
    image = nibabel.Nifti1Image(part, affine)
    image.header.set_xyzt_units(unit)
    scan = read_scan(image.to_bytes())
    assert scan.unit == "mm"
    assert 1e3 * scan.lesions[0].radius == pytest.approx(RADIUS, abs=0.1)
    assert not any("names no unit" in note for note in scan.notes)
    image.header.set_xyzt_units(0)
    if factor == 1.0:
        assert any(
            "The file names no unit of length; it was read in mm" in note for note in read_scan(image.to_bytes()).notes
        )
    else:
        with pytest.raises(BadInput, match="check its unit"):
            read_scan(image.to_bytes())


def test_a_unit_that_a_person_says_is_refused_where_the_file_has_its_own() -> None:
    assert read_scan(nifti(body_labels()), units="mm").unit == "mm"
    for units in ("cm", "m", "in"):
        with pytest.raises(BadInput, match="has a unit of its own, and is read in mm; leave units out"):
            read_scan(nifti(body_labels()), units=units)


def test_a_lesion_alone_is_no_body() -> None:
    at = np.stack(np.meshgrid(*[np.arange(80.0)] * 3, indexing="ij"), axis=-1)
    for radius, inside in ((30.0, slice(None)), (38.0, slice(2, 78))):
        ball = (np.linalg.norm(at - 39.5, axis=-1) < radius)[inside, inside, inside]
        with pytest.raises(BadInput, match="This label map shows no body"):
            read_scan(nifti(ball.astype(np.uint8), sizes=np.ones(3)))
