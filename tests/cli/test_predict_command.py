"""`breastrig predict` as a user calls it, on the example patient, who was scanned lying as well."""

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.example_fits import write_example_fits

import breastrig
from breastrig.cli.main import main
from breastrig.files.result import FIT_FILES
from breastrig.rig.similarity import umeyama


@pytest.fixture(scope="module")
def fits(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("fits")
    write_example_fits(out)
    assert main(["predict", str(out / "standing"), "--stance", "supine", "-o", str(out / "predicted")]) == 0
    return out


def test_the_files_are_those_of_a_fit_and_say_that_they_are_predicted(fits: Path) -> None:
    assert {file.name for file in (fits / "predicted").iterdir()} == set(FIT_FILES)
    standing, lying = (json.loads((fits / name / "result.json").read_text()) for name in ("standing", "predicted"))
    assert (lying["predicted"], lying["stance"]) == (True, "supine")
    assert "predicted" not in standing
    assert lying["line_error_mm"] > standing["line_error_mm"]
    assert lying["landmark_uncertainty_mm"]["nipple_L"] > standing["landmark_uncertainty_mm"]["nipple_L"]
    assert lying["landmarks_picked"].keys() == standing["landmarks_picked"].keys()


def test_a_drawing_is_shown_where_the_prediction_has_its_skin(fits: Path, tmp_path: Path) -> None:
    there = tmp_path / "there.json"
    assert main(["transfer", "--from", str(fits / "standing"), "--to", str(fits / "predicted"), "-o", str(there)]) == 0
    own = json.loads((fits / "predicted" / "drawing.json").read_text())
    for carried, moved in zip(json.loads(there.read_text())["shapes"], own["shapes"], strict=True):
        points, skin = np.array(carried["points"]), np.array(moved["points"])
        near = np.linalg.norm(skin[:, None] - points, axis=2).min(axis=1)
        assert np.median(near) < (2.0 if own["unit"] == "mm" else 0.002)


def test_the_prediction_is_nearer_to_the_lying_patient_than_she_was_standing(fits: Path) -> None:
    standing, lying, foretold = (breastrig.Fit.load(fits / name) for name in ("standing", "supine", "predicted"))
    names = sorted(standing.picked.keys() & lying.picked.keys())
    true = lying.metres_per_unit * np.array([lying.picked[name] for name in names])

    def nipples(fit: breastrig.Fit) -> float:
        """m, from where they are lying, after the rigid motion that fits all landmarks best."""
        marks = fit.metres_per_unit * np.array([fit.picked[name] for name in names])
        turn = umeyama(marks, true).rotation
        gaps = np.linalg.norm((marks - marks.mean(axis=0)) @ turn.T + true.mean(axis=0) - true, axis=1)
        return float(np.mean([gap for name, gap in zip(names, gaps, strict=True) if name.startswith("nipple")]))

    assert nipples(foretold) < 0.75 * nipples(standing)


def test_programs_predict_what_the_command_does(fits: Path) -> None:
    fit = breastrig.predict(breastrig.Fit.load(fits / "standing"), "supine")
    assert fit.stance == "supine"
    assert fit.vertices == pytest.approx(breastrig.Fit.load(fits / "predicted").vertices, rel=1e-5, abs=1e-5)


def test_a_prediction_is_not_predicted_from(fits: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["predict", str(fits / "predicted"), "--stance", "prone", "-o", str(tmp_path / "out")]) == 2
    assert "is itself predicted; predict from the fit of a scan." in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
