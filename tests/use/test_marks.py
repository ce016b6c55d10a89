"""Marks through fits: from a file or a program, into result.json, and back."""

import json
from pathlib import Path

import numpy as np
import pytest

import breastrig
from breastrig.cli.main import main
from breastrig.core.assets import asset_folder

EXAMPLE = asset_folder("example") / "standing"


def picks() -> dict[str, list[float]]:
    found: dict[str, list[float]] = json.loads((EXAMPLE / "landmarks.json").read_text())["landmarks"]
    return found


@pytest.fixture(scope="module")
def scan() -> breastrig.Scan:
    return breastrig.read_scan(EXAMPLE / "scan.ply")


@pytest.fixture(scope="module")
def fit(scan: breastrig.Scan) -> breastrig.Fit:
    """With three marks: on the skin, 4 mm off, and 40 mm off."""
    outwards = np.array(scan.vertices[1000]) - scan.vertices.mean(axis=0)
    outwards *= 1e-3 / (scan.metres_per_unit * np.linalg.norm(outwards))
    marks = {f"{mm} mm": scan.vertices[1000] + mm * outwards for mm in (0, 4, 40)}
    return breastrig.fit(scan, EXAMPLE / "landmarks.json", marks=marks, refine=False)


def test_the_result_says_where_on_the_skin_each_mark_is(fit: breastrig.Fit, scan: breastrig.Scan) -> None:
    found = fit.result["marks"]
    assert list(found) == list(fit.marks) == ["0 mm", "4 mm", "40 mm"]
    np.testing.assert_allclose(fit.marks["0 mm"], scan.vertices[1000], atol=1e-6)
    assert found["0 mm"]["off_scan_mm"] < 1e-3
    assert 0.0 < found["4 mm"]["off_scan_mm"] <= 4.001
    corners = fit.vertices[fit.faces[found["0 mm"]["face"]]]
    on_model = np.array(found["0 mm"]["barycentric"]) @ corners
    nearest = np.linalg.norm(fit.vertices - fit.marks["0 mm"], axis=1).min()
    assert np.linalg.norm(on_model - fit.marks["0 mm"]) <= nearest


def test_a_mark_off_the_skin_is_asked_about_and_not_followed(fit: breastrig.Fit) -> None:
    [asked] = fit.result["marks_asked"]
    assert asked["names"] == ["40 mm"]
    assert asked["reason"].startswith("The mark 40 mm is ")
    assert list(fit.in_metres.fitted_scan.marks) == ["0 mm", "4 mm"]


def test_marks_are_saved_and_loaded(fit: breastrig.Fit, tmp_path: Path) -> None:
    fit.save(tmp_path / "out")
    again = breastrig.Fit.load(tmp_path / "out")
    assert again.result["marks"] == fit.result["marks"]
    assert {name: place.tolist() for name, place in again.marks.items()} == {
        name: place.tolist() for name, place in fit.marks.items()
    }


@pytest.mark.slow
def test_marks_change_nothing_of_the_fit_itself(fit: breastrig.Fit, scan: breastrig.Scan) -> None:
    plain = breastrig.fit(scan, EXAMPLE / "landmarks.json", refine=False)
    np.testing.assert_array_equal(plain.vertices, fit.vertices)
    assert "marks" not in plain.result
    same = fit.result.keys() - {"marks", "marks_asked", "timing_s", "fields", "files"}
    assert {name: plain.result[name] for name in same} == {name: fit.result[name] for name in same}


@pytest.mark.slow
def test_names_in_a_table_that_no_landmark_has_are_marks_and_are_listed(tmp_path: Path, capsys) -> None:
    rows = [f"{name},{x},{y},{z}" for name, (x, y, z) in (picks() | {"mole": picks()["nipple_L"]}).items()]
    (tmp_path / "picks.csv").write_text("\n".join(["name,x [mm],y [mm],z [mm]", *rows]))
    command = ["fit", str(EXAMPLE / "scan.ply"), "--landmarks", str(tmp_path / "picks.csv"), "--no-refine"]
    assert main([*command, "-o", str(tmp_path / "out")]) == 0
    assert "Taken as marks, as no landmark has these names: mole." in capsys.readouterr().err
    result = json.loads((tmp_path / "out" / "result.json").read_text())
    assert list(result["marks"]) == ["mole"]
    assert result["landmarks_picked"].keys() == picks().keys()


@pytest.mark.parametrize(
    ("marks", "says"),
    [
        ({"nipple_Left": [0.0, 0.0, 0.0]}, r'^Is "nipple_Left" the landmark nipple_L\?'),
        ({"mole": [0.0, 0.0]}, "The mark mole needs three finite numbers"),
        ({"mole": [1e6, 0.0, 0.0]}, "The mark mole is .* away from the scan; place it on this scan"),
    ],
)
def test_marks_that_cannot_be_meant_are_refused(marks, says: str, scan: breastrig.Scan) -> None:
    with pytest.raises(breastrig.BadLandmarks, match=says):
        breastrig.fit(scan, marks=marks)
