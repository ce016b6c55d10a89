"""The examples run as they are shown, with warnings as errors, and still make the pictures of their pages."""

import csv
import json
import re
import runpy
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.blank_pictures import coarse_pictures
from matplotlib import pyplot as plt
from PIL import Image

import breastrig
from breastrig.core.assets import asset_folder

Fits = dict[tuple[Any, ...], breastrig.Fit]

pytestmark = pytest.mark.long

EXAMPLES = Path(__file__).parents[2] / "server" / "examples"
PROGRAMS = sorted(path.stem for path in EXAMPLES.glob("*.py"))
PICTURES = EXAMPLES.parents[1] / "docs" / "pictures" / "examples"
HELD_ELSEWHERE = {  # below; HTTP as docs show it in test_readme.py; fits with few picks in use/test_line_checks.py
    *("folder_to_table", "http_client", "ablation", "landmarks_checked"),
}
ALIKE = 6.0  # mean difference of pixels, of 255: letters of another font, not another picture


@pytest.fixture(scope="module")
def fits() -> Fits:
    return {}


def ran(name: str, folder: Path, fits: Fits, monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs a program in that folder; the same fit is made once for all that ask for it."""
    script = str(EXAMPLES / f"{name}.py")
    fitted: Callable[..., breastrig.Fit] = breastrig.fit

    def fit(*given: Any, **options: Any) -> breastrig.Fit:
        if options or not all(isinstance(each, Path) for each in given):
            return fitted(*given, **options)
        if given not in fits:
            fits[given] = fitted(*given)
        return fits[given]

    monkeypatch.setattr(breastrig, "fit", fit)
    monkeypatch.setattr(sys, "argv", [script])
    monkeypatch.chdir(folder)
    runpy.run_path(script, run_name="__main__")
    plt.close("all")


@pytest.mark.parametrize("name", [name for name in PROGRAMS if name not in HELD_ELSEWHERE])
def test_it_runs_without_an_argument_and_makes_its_picture(
    name: str, tmp_path: Path, fits: Fits, monkeypatch: pytest.MonkeyPatch
) -> None:
    coarse_pictures(monkeypatch)
    ran(name, tmp_path, fits, monkeypatch)
    with Image.open(tmp_path / f"{name}.png") as made, Image.open(PICTURES / f"{name}.webp") as shown:
        here, there = (np.asarray(each.convert("RGB").resize((240, 160)), dtype=float) for each in (made, shown))
        assert abs(made.width / made.height - shown.width / shown.height) < 0.02
    assert np.abs(here - there).mean() < ALIKE, f"make its picture anew: python server/examples/{name}.py"


def test_every_program_has_its_page_in_the_list() -> None:
    listed = re.findall(r"^([a-z_]+)$", (EXAMPLES.parents[1] / "docs/examples/index.md").read_text(), re.MULTILINE)
    assert sorted(listed) == PROGRAMS
    for name in PROGRAMS:
        title, _, words = EXAMPLES.joinpath(f"{name}.py").read_text("utf-8").split('"""')[1].partition("\n\n")
        assert title.endswith((".", "?"))
        assert len(words) > 60, f"{name}.py: its docstring is its page"


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


def test_a_folder_of_scans_becomes_a_table(tmp_path: Path) -> None:
    (tmp_path / "scans").mkdir()
    for name in ("standing", "supine"):
        shutil.copy(asset_folder("example") / name / "scan.ply", tmp_path / "scans" / f"{name}.ply")
        shutil.copy(asset_folder("example") / name / "landmarks.json", tmp_path / "scans" / f"{name}.json")
    (tmp_path / "scans" / "broken.ply").write_bytes(b"ply\n")
    runpy.run_path(str(EXAMPLES / "folder_to_table.py"))["main"](str(tmp_path / "scans"), str(tmp_path / "table.csv"))
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
        unknown = {"base_width_L", "base_width_R"} if row["stance"] == "supine" else set()  # not measurable lying
        assert {name for name, value in measured.items() if not value} == unknown
        assert min(float(value) for value in measured.values() if value) > 10.0
