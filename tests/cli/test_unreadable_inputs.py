"""Names and files that cannot be: one clear short line and exit code 2 from every command, at once."""

import json
import os
import re
from pathlib import Path

import pytest

from breastrig.cli.main import main
from breastrig.core.assets import asset_folder
from breastrig.core.errors import BadDrawing, BadLandmarks
from breastrig.drawings.drawing_file import parsed_drawing
from breastrig.rig.model import Rig
from breastrig.use.steps.prepare import checked_landmarks

EXAMPLE = asset_folder("example") / "standing"
SCAN, PICKS = str(EXAMPLE / "scan.ply"), str(EXAMPLE / "landmarks.json")
LONG = "n" * 5000
DEEP = "/".join(["n" * 100] * 60)


def line(command: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    assert main(command) == 2
    said = capsys.readouterr()
    assert said.err.startswith("breastrig: ")
    assert said.err.count("\n") == 1
    assert len(said.err) < 700
    return said.err


@pytest.fixture
def pipe(tmp_path: Path) -> str:
    """Whoever opens it for reading waits for ever."""
    os.mkfifo(tmp_path / "pipe")
    return str(tmp_path / "pipe")


@pytest.mark.parametrize("name", [LONG, DEEP])
@pytest.mark.parametrize(
    "words",
    [
        ["fit", "NAME"],
        ["fit", SCAN, "--landmarks", "NAME"],
        ["fit", SCAN, "--cuts", "NAME"],
        ["fit", SCAN, "--model", "NAME.glb"],
        ["fit", SCAN, "--preset", "NAME.toml"],
        ["fit", SCAN, "--drawing", "NAME"],
        ["landmarks", "NAME"],
        ["transfer", "--from", "NAME", "--to", "NAME"],
        ["transfer", "--from", "here", "--to", "here", "--drawing", "NAME"],
        ["compare", "NAME", "NAME", "--on", "NAME"],
        ["report", "NAME"],
        ["export", "NAME"],
        ["batch", "NAME"],
        ["evaluate", "NAME"],
    ],
)
def test_an_endless_name_is_one_short_line(
    words: list[str], name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = [word.replace("NAME", name) for word in words]
    line([*command, "-o", str(tmp_path / "out")], capsys)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", [LONG, DEEP])
@pytest.mark.parametrize(
    "words", [["fit", SCAN], ["landmarks", SCAN], ["report", "here"], ["export", "here"], ["evaluate", "here"]]
)
def test_an_endless_name_of_an_output_is_one_short_line(
    words: list[str], name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    line([*words, "-o", str(tmp_path / name)], capsys)


@pytest.mark.parametrize(
    "words",
    [
        ["fit", "FILE"],
        ["fit", SCAN, "--landmarks", "FILE"],
        ["fit", SCAN, "--model", "FILE"],
        ["landmarks", "FILE"],
        ["transfer", "--from", "here", "--to", "here", "--drawing", "FILE"],
        ["compare", "FILE", "FILE", "--on", "here"],
        ["batch", "FILE"],
    ],
)
@pytest.mark.parametrize("kind", ["pipe", "device", "folder"])
def test_neither_pipe_nor_device_nor_folder_is_read(
    words: list[str], kind: str, pipe: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = {"pipe": pipe, "device": "/dev/zero", "folder": str(tmp_path)}[kind]
    line([file if word == "FILE" else word for word in words] + ["-o", str(tmp_path / "out")], capsys)


def test_a_preset_that_is_not_there_is_called_missing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = line(["fit", SCAN, "--preset", "my.toml", "-o", str(tmp_path / "out")], capsys)
    assert said == "breastrig: The preset my.toml is not there or is no file; check the name.\n"


def test_a_folder_whose_files_are_pipes_is_no_fit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    os.mkfifo(tmp_path / "result.json")
    assert "There is no fit in" in line(["report", str(tmp_path), "-o", str(tmp_path / "out")], capsys)


@pytest.mark.parametrize("value", ["1e308", "-1e300", "1e12"])
def test_a_coordinate_that_is_far_too_large_is_one_short_line(
    value: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    document = json.loads(Path(PICKS).read_text())
    document["landmarks"]["xiphoid"][0] = float(value)
    (tmp_path / "far.json").write_text(json.dumps(document))
    said = line(["fit", SCAN, "--landmarks", str(tmp_path / "far.json"), "-o", str(tmp_path / "out")], capsys)
    assert 'The landmark "xiphoid" has a coordinate larger than 1e9' in said


@pytest.mark.parametrize(("millimetres", "words"), [(9000.0, "8[0-9]{3} mm"), (5e7, "[0-9]{2},[0-9]{3} m")])
def test_a_far_landmark_is_reported_in_readable_numbers(
    millimetres: float, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    document = json.loads(Path(PICKS).read_text())
    document["landmarks"]["xiphoid"] = [0.0, millimetres, 0.0]
    (tmp_path / "far.json").write_text(json.dumps(document))
    said = line(["fit", SCAN, "--landmarks", str(tmp_path / "far.json"), "-o", str(tmp_path / "out")], capsys)
    assert re.search(words, said)


def test_what_the_service_is_sent_is_held_to_the_same_limits(toy_rig: Rig) -> None:
    with pytest.raises(BadLandmarks, match="larger than 1e9"):
        checked_landmarks(toy_rig, {toy_rig.landmark_names[0]: [1e308, 0.0, 0.0]})
    shapes = [{"name": "line", "points": [[1e308, 0.0, 0.0]]}]
    with pytest.raises(BadDrawing, match="less than or equal to"):
        parsed_drawing({"schema": "breastrig/drawing@1", "shapes": shapes}, toy_rig, "mm")
