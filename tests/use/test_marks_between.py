"""Marks that the scans of two fits share, through Python and the command line: followed, asked about, listed."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import breastrig
from breastrig.cli.main import main
from breastrig.core.assets import asset_folder
from breastrig.scan.landmarks.landmark_files import read_landmarks

EXAMPLE = asset_folder("example")
NAMES = {"nipple_L": "dot left", "nipple_R": "dot right", "inframammary_fold_L": "mole", "xiphoid": "scar"}
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Both stances, some landmarks given as marks of other names; the supine one has a mark of its own."""
    made = {}
    for stance in ("standing", "supine"):
        places, unit = read_landmarks(EXAMPLE / stance / "landmarks.json")
        marks = {name: places[landmark].tolist() for landmark, name in NAMES.items()}
        marks |= {"lone": marks["mole"]} if stance == "supine" else {}
        own = {name: place.tolist() for name, place in places.items() if name not in NAMES}
        file = tmp_path_factory.mktemp("marks") / "landmarks.json"
        file.write_text(json.dumps({"landmarks": own, "marks": marks, "unit": unit}))
        made[stance] = file.with_name(stance)
        scan = str(EXAMPLE / stance / "scan.ply")
        assert main(["fit", scan, "--landmarks", str(file), "--no-refine", "-o", str(made[stance])]) == 0
    return made


def at(folders: dict[str, Path], stance: str, name: str) -> np.ndarray:
    return breastrig.Fit.load(folders[stance]).marks[name]


def test_a_line_follows_the_marks(folders: dict[str, Path], tmp_path: Path, capsys) -> None:
    here, there = at(folders, "standing", "dot left"), at(folders, "supine", "dot left")
    drawing = {"shapes": [{"name": "line", "points": [here.tolist()]}]}
    (tmp_path / "drawing.json").write_text(json.dumps(drawing))
    command = ["transfer", "--from", str(folders["standing"]), "--to", str(folders["supine"])]
    assert main([*command, "--drawing", str(tmp_path / "drawing.json"), "-o", str(tmp_path / "there.json")]) == 0
    said = capsys.readouterr().err
    assert "Marks followed: dot left, dot right, mole, scar." in said
    assert "Marks on one of the scans only, not followed: lone." in said
    [shape] = json.loads((tmp_path / "there.json").read_text())["shapes"]
    mm = 1e3 * breastrig.Fit.load(folders["supine"]).metres_per_unit
    assert mm * np.linalg.norm(np.array(shape["points"][0]) - there) < 4.0
    fits = [breastrig.Fit.load(folders[stance]).in_metres for stance in ("standing", "supine")]
    of_folders = breastrig.transfer(folders["standing"], folders["supine"], drawing).document
    assert of_folders["shapes"] == [shape]
    plain = [replace(fit, marks={}) for fit in fits]
    assert [fit.fitted_scan.marks for fit in plain] == [{}, {}]


def test_a_wrong_pair_is_asked_about_by_name(folders: dict[str, Path], tmp_path: Path) -> None:
    wrong, per_mm = breastrig.Fit.load(folders["supine"]), 1e-3 / breastrig.Fit.load(folders["supine"]).metres_per_unit
    places = dict(wrong.marks) | {"mole": wrong.marks["mole"] + 40 * per_mm * wrong.frame.up}
    nearest = np.argmin(np.linalg.norm(wrong.scan_vertices - places["mole"], axis=1))
    places["mole"] = wrong.scan_vertices[nearest]
    again = breastrig.fit(EXAMPLE / "supine" / "scan.ply", wrong.picked, marks=places, refine=False)
    plan = {
        "schema": "breastrig/plan@1",
        "items": [{"kind": "tumour", "id": "t", "side": "L", "clock": 3, "distance_mm": 30,
                   "radius_mm": 10, "scan": "standing"}],
    }  # fmt: skip
    for drawing in ({"shapes": [{"name": "x", "points": [at(folders, "standing", "mole").tolist()]}]}, plan):
        marks = breastrig.transfer(folders["standing"], again, drawing, same_patient=True).document["marks"]
        assert marks["followed"] == ["dot left", "dot right", "scar"]
        assert marks["unpaired"] == ["lone"]
        [asked] = marks["asked"]
        assert asked["name"] == "mole"
        assert asked["says"].startswith("The mark mole is ")
        assert asked["says"].endswith("and was not followed. Is it the same place on both?")


def test_a_prediction_keeps_the_marks(folders: dict[str, Path]) -> None:
    standing = breastrig.Fit.load(folders["standing"])
    predicted = breastrig.predict(standing, "supine")
    assert predicted.marks.keys() == standing.marks.keys()
    mm = 1e3 * standing.metres_per_unit
    moved = {name: mm * np.linalg.norm(predicted.marks[name] - standing.marks[name]) for name in standing.marks}
    assert moved["scar"] < 15.0 < moved["dot left"]
    document = breastrig.transfer(standing, predicted).document
    assert document["marks"]["asked"] == []
    assert document["marks"]["followed"] == list(standing.marks)


def test_other_patients_share_no_marks(folders: dict[str, Path]) -> None:
    document = breastrig.transfer(folders["standing"], folders["supine"], other_patient=True).document
    assert "marks" not in document
