"""Drawings carried between two stances, from a program: in every digit what the commands write."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.example_fits import write_example_fits

import breastrig
from breastrig.cli.main import main
from breastrig.core.assets import asset_folder

pytestmark = pytest.mark.long

EXAMPLE = asset_folder("example")
SCANS = [EXAMPLE / name / "scan.ply" for name in ("standing", "supine")]
PICKS = [EXAMPLE / name / "landmarks.json" for name in ("standing", "supine")]


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Fits of the command, standing and supine."""
    folder = tmp_path_factory.mktemp("fits")
    write_example_fits(folder)
    return folder / "standing", folder / "supine"


@pytest.fixture(scope="module")
def fits() -> tuple[breastrig.Fit, breastrig.Fit]:
    """The same in memory."""
    return breastrig.fit(SCANS[0], PICKS[0]), breastrig.fit(SCANS[1], PICKS[1])


def document(file: Path) -> dict:
    found: dict = json.loads(file.read_text())
    return found


@pytest.mark.slow
def test_a_drawing_is_carried_as_the_command_carries_it(
    fits: tuple[breastrig.Fit, breastrig.Fit], folders: tuple[Path, Path], tmp_path: Path
) -> None:
    there = tmp_path / "there.json"
    assert main(["transfer", "--from", str(folders[0]), "--to", str(folders[1]), "-o", str(there)]) == 0
    of_fits, of_folders = breastrig.transfer(*fits), breastrig.transfer(*folders)
    assert of_folders.document == document(there)
    assert of_fits.document == {name: said for name, said in document(there).items() if name != "patient"}
    of_folders.save(tmp_path / "ours.json")
    assert (tmp_path / "ours.json").read_bytes() == there.read_bytes()
    for line, shape in zip(of_fits.lines, document(there)["shapes"], strict=True):
        assert line.bridged is not None
        assert line.distance_to_mm is not None
        np.testing.assert_array_equal(line.points, shape["points"])
        np.testing.assert_array_equal(line.bridged, np.isnan(line.distance_to_mm))
    with pytest.raises(breastrig.BadInput, match="which this command reads"):
        of_folders.save(folders[1] / "drawing.json", force=True)


def test_a_programs_own_lines_are_carried_in_the_scans_unit(fits: tuple[breastrig.Fit, breastrig.Fit]) -> None:
    a, b = fits
    around = next(line for line in a.drawing.lines if line.name == "breast_L")
    assert around.bridged is not None
    points = around.points[~around.bridged][::5]
    one = breastrig.transfer(a, b, [breastrig.Line("mine", points, closed=True)])
    written = {"unit": "mm", "shapes": [{"name": "mine", "closed": True, "points": (1e3 * points).tolist()}]}
    other = breastrig.transfer(a, b, written)
    again = breastrig.transfer(a, b, breastrig.Drawing("mine", "mm", (), written))
    (line,), (same,) = one.lines, other.lines
    assert (line.name, line.closed, one.unit) == ("mine", True, "m")
    np.testing.assert_allclose(line.points, same.points, atol=2e-6)
    assert again.document == other.document
    assert np.linalg.norm(line.points.mean(axis=0) - b.landmarks["nipple_L"]) < 0.1


def test_what_cannot_be_carried_is_said_in_one_sentence(fits: tuple[breastrig.Fit, breastrig.Fit]) -> None:
    a, b = fits
    with pytest.raises(breastrig.BadDrawing, match=r"it must be \(M, 3\)"):
        breastrig.transfer(a, b, [breastrig.Line("flat", np.zeros((4, 2)))])
    with pytest.raises(breastrig.BadDrawing, match=r"give breastrig\.Line"):
        breastrig.transfer(a, b, [np.zeros((4, 3))])
    rig = replace(a.in_metres.rig, name="other", sha256="0" * 64)
    other = replace(a, in_metres=replace(a.in_metres, rig=rig))
    with pytest.raises(breastrig.BadInput, match=r"made with several models \(other 0{12}, torso \w{12}\)"):
        breastrig.transfer(other, b)
    with pytest.raises(breastrig.BadDrawing, match="are no numbers"):
        breastrig.transfer(a, b, [breastrig.Line("words", ["here", "there"])])
    with pytest.raises(breastrig.BadDrawing, match=r"away from the scan|off the"):
        breastrig.transfer(a, b, [breastrig.Line("far", np.full((4, 3), 5.0))])
    with pytest.raises(breastrig.BadInput, match="There is no fit in nowhere"):
        breastrig.transfer(a, "nowhere")
