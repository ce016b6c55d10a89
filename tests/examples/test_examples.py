"""The examples run as they are shown, with warnings as errors; one in a process of its own."""

import csv
import json
import re
import runpy
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from helpers.example_fits import write_example_fits
from PIL import Image

from breastrig.cli.main import main
from breastrig.core.assets import asset_folder

pytestmark = pytest.mark.long

EXAMPLE = asset_folder("example")
STANDING, SUPINE = EXAMPLE / "standing", EXAMPLE / "supine"
Run = Callable[..., tuple[object, str, str]]


@pytest.fixture
def run(repository: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Runs an example here; what it is left with, and what it says on both streams."""

    def run(name: str, *arguments: Path | str) -> tuple[object, str, str]:
        script = repository / "server" / "examples" / name
        monkeypatch.setattr(sys, "argv", [str(script), *map(str, arguments)])
        code: object = 0
        try:
            runpy.run_path(str(script), run_name="__main__")
        except SystemExit as left:
            code = left.code
        said = capsys.readouterr()
        return code, said.out, said.err

    return run


def test_every_example_is_run_here(repository: Path) -> None:
    there = {file.name for file in (repository / "server" / "examples").iterdir() if file.suffix == ".py"}
    assert there == {"fit_with_plot.py", "folder_to_table.py", "drawing_between_stances.py", "weight_of_breasts.py"}


def test_one_fit_is_watched_and_drawn(repository: Path, tmp_path: Path) -> None:
    scan, landmarks = STANDING / "scan.ply", STANDING / "landmarks.json"
    script = str(repository / "server" / "examples" / "fit_with_plot.py")
    command = [sys.executable, "-W", "error", script, str(scan), str(landmarks), str(tmp_path / "fit.png")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    assert "<Fit: standing, good" in done.stdout
    with Image.open(tmp_path / "fit.png") as picture:
        pixels = np.asarray(picture.convert("RGB"))
    assert pixels.shape[1] > pixels.shape[0] > 500
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) > 500  # colours of the distances, not an empty frame


def test_the_tutorial_notebook_runs_and_keeps_no_output(
    repository: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(repository)
    names: dict[str, object] = {}
    for cell in json.loads((repository / "docs/tutorial.ipynb").read_text("utf-8"))["cells"]:
        if cell["cell_type"] == "code":
            assert cell["outputs"] == [], "clear the outputs: they are pictures of old versions"
            exec("".join(cell["source"]), names)
    said = capsys.readouterr().out
    assert said.startswith("good")
    assert "breast_L" in said


def test_a_folder_of_scans_becomes_a_table(run: Run, tmp_path: Path) -> None:
    (tmp_path / "scans").mkdir()
    for name in ("standing", "supine"):
        shutil.copy(EXAMPLE / name / "scan.ply", tmp_path / "scans" / f"{name}.ply")
        shutil.copy(EXAMPLE / name / "landmarks.json", tmp_path / "scans" / f"{name}.json")
    (tmp_path / "scans" / "broken.ply").write_bytes(b"ply\n")
    code, _, errors = run("folder_to_table.py", tmp_path / "scans", tmp_path / "table.csv")
    assert not code, errors
    with open(tmp_path / "table.csv", newline="") as table:
        broken, *rows = csv.DictReader(table)
    assert broken["problem"].endswith(".")
    assert broken["stance"] == ""
    assert [(row["scan"], row["stance"], row["verdict"]) for row in rows] == [
        ("standing.ply", "standing", "good"),
        ("supine.ply", "supine", "good"),
    ]
    for row in rows:
        measured = {name: value for name, value in row.items() if name.endswith(("_L", "_R"))}
        assert len(measured) == 8
        unknown = (
            {"base_width_L", "base_width_R"} if row["stance"] == "supine" else set()
        )  # nobody can measure it lying
        assert {name for name, value in measured.items() if not value} == unknown
        assert min(float(value) for value in measured.values() if value) > 10.0


@pytest.mark.parametrize("with_landmarks", [True, False])
def test_a_drawing_is_carried_between_stances(run: Run, tmp_path: Path, with_landmarks: bool) -> None:
    picks = [STANDING / "landmarks.json", SUPINE / "landmarks.json"] if with_landmarks else []
    result = tmp_path / "there.json"
    arguments = (STANDING / "scan.ply", SUPINE / "scan.ply", result, *picks)
    code, output, errors = run("drawing_between_stances.py", *arguments)
    assert not code, errors
    (shape,) = json.loads(result.read_text())["shapes"]
    assert shape["name"] == "circle"
    assert shape["closed"]
    there_and_back = float(output.split("it is ")[1].split(" mm")[0])
    assert there_and_back < 1.5


def test_an_example_says_in_a_sentence_what_is_wrong(run: Run, tmp_path: Path) -> None:
    code, _, _ = run("fit_with_plot.py", tmp_path / "none.ply", STANDING / "landmarks.json", tmp_path / "a.png")
    assert isinstance(code, str)  # with which Python ends a program in 1 and this line on standard error
    assert code.startswith("There is no scan file")
    assert "\n" not in code


def test_breasts_weigh_on_the_mesh_as_it_is_written(run: Run, tmp_path: Path) -> None:
    write_example_fits(tmp_path)
    assert main(["volume", str(tmp_path / "standing"), "-o", str(tmp_path / "torso.msh")]) == 0
    unit = json.loads((tmp_path / "standing" / "result.json").read_text())["scan"]["unit"]
    _, said, _ = run("weight_of_breasts.py", tmp_path / "torso.msh", unit, "0", "0", "-1")
    assert re.search(r"^breast_L: up to [1-9]\d?\.\d mm\nbreast_R: up to [1-9]\d?\.\d mm$", said, re.MULTILINE)
