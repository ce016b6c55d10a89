"""`breastrig transfer` and `breastrig compare` as a user calls them, on the example patient standing and lying."""

import csv
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from helpers.blank_pictures import blank_pictures
from helpers.example_fits import write_example_fits
from helpers.results import without_hashes
from PIL import Image

from breastrig.cli.main import main
from breastrig.correspondence.target import ScanTarget
from breastrig.use.folder.fit_folder import FitFolder, read_fit_folder

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def fits(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("fits")
    write_example_fits(out)
    return out


def transfer(fits: Path, start: str, goal: str, out: Path, *more: str) -> dict:
    command = ["transfer", "--from", str(fits / start), "--to", str(fits / goal), "-o", str(out), *more]
    assert main(command) == 0
    return json.loads(out.read_text())


def skin(folder: FitFolder) -> ScanTarget:
    return ScanTarget(folder.surface.vertices, folder.surface.faces)


def test_every_point_lies_on_the_other_scan_or_is_bridged(fits: Path, tmp_path: Path) -> None:
    drawing = transfer(fits, "standing", "supine", tmp_path / "there" / "drawing.json")
    goal = read_fit_folder(fits / "supine")
    assert (drawing["schema"], drawing["unit"]) == ("breastrig/drawing@1", goal.unit)
    assert "Research use only" in drawing["notice"]
    for shape in drawing["shapes"]:
        points, bridged = goal.metres_per_unit * np.array(shape["points"]), np.array(shape["bridged"])
        assert skin(goal).search.query(points[~bridged]).distances.max() < 0.3e-3
        assert bridged.mean() < 0.3
        assert len(shape["distance_from_mm"]) == len(shape["distance_to_mm"]) == len(points)


def test_by_the_place_on_the_model_the_same_scan_has_the_same_drawing(fits: Path, tmp_path: Path) -> None:
    back = transfer(fits, "standing", "standing", tmp_path / "back.json", "--other-patient")
    folder = read_fit_folder(fits / "standing")
    left = json.loads((fits / "standing" / "drawing.json").read_text())
    for before, after in zip(left["shapes"], back["shapes"], strict=True):
        points, bridged = np.array(before["points"]), np.array(before["bridged"])
        near = np.linalg.norm(np.array(after["points"])[:, None] - points, axis=2).min(axis=0)
        assert folder.metres_per_unit * near[~bridged].max() < 0.5e-3


@pytest.mark.parametrize(
    ("drawing", "word"),
    [
        ('{"shapes": []}', "empty"),
        ("Dear surgeon", "not JSON"),
        ('{"shapes": [{"name": "a", "surface_points": [{"face": 99999, "barycentric": [1, 0, 0]}]}]}', "another model"),
        (None, "no drawing"),
    ],
)
def test_a_drawing_that_cannot_be_carried_is_one_line(
    drawing: str | None, word: str, fits: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if drawing is not None:
        (tmp_path / "bad.json").write_text(drawing)
    pair = ["--from", str(fits / "standing"), "--to", str(fits / "supine")]
    code = main(["transfer", *pair, "--drawing", str(tmp_path / "bad.json"), "-o", str(tmp_path / "out.json")])
    said = capsys.readouterr().err
    assert code == 2
    assert word in said
    assert said.count("\n") == 1
    assert not (tmp_path / "out.json").exists()


def test_it_says_which_points_it_moved_onto_the_skin(
    fits: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = read_fit_folder(fits / "standing")
    target, marks = skin(folder), folder.landmarks
    middle = [marks["xiphoid"] + share * (marks["mid_sternum"] - marks["xiphoid"]) for share in np.linspace(0, 1, 8)]
    on = target.search.query(np.array(middle))
    out = target.surface_at(on.faces, on.barycentric)[1]
    off = np.array([0.0, 0.0004, 0.003, 0.003, 0.006, 0.0, 0.002, 0.0004])[:, None]
    lines = {"off": on.points + off * out, "on": on.points, "one": (on.points + off * out)[5:]}
    shapes = [{"name": name, "points": (1e3 * points).tolist()} for name, points in lines.items()]
    (tmp_path / "given.json").write_text(json.dumps({"unit": "mm", "shapes": shapes}))
    found = transfer(fits, "standing", "supine", tmp_path / "out.json", "--drawing", str(tmp_path / "given.json"))
    said = [
        '"off": points 3 to 5 and 7 were moved onto the skin, by up to 6 mm.',
        '"one": point 2 was moved onto the skin, by 2 mm.',
    ]
    assert found["moved"] == said
    assert [line for line in capsys.readouterr().err.splitlines() if "moved" in line] == [
        f"breastrig: {each}" for each in said
    ]


def test_a_folder_that_is_no_fit_is_one_line(fits: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pair = ["--from", str(fits / "standing"), "--to", str(tmp_path)]
    assert main(["transfer", *pair, "-o", str(tmp_path / "out.json")]) == 2
    assert "There is no fit in" in capsys.readouterr().err


def test_two_drawings_are_superimposed(fits: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    blank_pictures(monkeypatch)
    there = transfer(fits, "standing", "supine", tmp_path / "there.json")
    own = fits / "supine" / "drawing.json"
    on = ["--on", str(fits / "supine")]
    assert main(["compare", str(own), str(tmp_path / "there.json"), *on, "-o", str(tmp_path / "cmp")]) == 0
    found = json.loads((tmp_path / "cmp" / "compare.json").read_text())
    assert [row["shape"] for row in found["distances"]] == [shape["name"] for shape in there["shapes"]]
    for row in found["distances"]:
        assert 0.0 < row["mean_mm"] <= row["p95_mm"] <= row["max_mm"] < 40.0
    with (tmp_path / "cmp" / "compare.csv").open(newline="") as table:
        assert [float(row["mean_mm"]) for row in csv.DictReader(table)] == [r["mean_mm"] for r in found["distances"]]
    with Image.open(tmp_path / "cmp" / "compare.png") as picture:
        assert picture.width > 1000
    assert main(["compare", str(own), str(own), *on, "-o", str(tmp_path / "same")]) == 0
    same = json.loads((tmp_path / "same" / "compare.json").read_text())
    assert max(row["max_mm"] for row in same["distances"]) < 1e-6
    assert same["only_in_one"] == []


def test_a_drawing_of_another_scan_cannot_be_compared(
    fits: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = [str(fits / name / "drawing.json") for name in ("supine", "standing")]
    command = ["compare", *files, "--on", str(fits / "supine"), "-o", str(tmp_path / "cmp")]
    assert main(command) == 2
    assert "add --same-patient" in capsys.readouterr().err
    assert main([*command, "--same-patient"]) == 2
    assert "have the same unit and frame" in capsys.readouterr().err


PLAN = {
    "schema": "breastrig/plan@1",
    "items": [
        {"kind": "tumour", "id": "t", "scan": "standing", "side": "L", "clock": 10, "distance_mm": 45, "radius_mm": 12},
        {"kind": "pattern", "id": "p", "scan": "standing", "name": "reduction", "parameters": {"side": "R"}},
        {"kind": "note", "id": "n", "text": "wants it smaller"},
    ],
}


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("plan") / "plan.json"
    file.write_text(json.dumps(PLAN))
    return file


def test_a_plan_is_carried_to_another_scan_than_it_names(fits: Path, plan: Path, tmp_path: Path) -> None:
    there = transfer(fits, "standing", "supine", tmp_path / "there.json", "--drawing", str(plan))
    assert {(shape["item"], shape["carried"]) for shape in there["shapes"]} == {("t", True), ("p", True)}
    assert there["missing"] == []
    assert there["notes"] == [{"item": "n", "text": "wants it smaller", "at": None}]


def test_an_export_has_the_plan_instead_of_the_fits_own_drawing(fits: Path, plan: Path, tmp_path: Path) -> None:
    assert main(["export", str(fits / "standing"), "--plan", str(plan), "-o", str(tmp_path / "alone")]) == 0
    content = (tmp_path / "alone" / "drawing.obj").read_text()
    assert "tumour_L" in content
    assert "sternum_upper" not in content


def test_what_a_label_map_shows_inside_is_carried_without_being_asked_for(fits: Path, tmp_path: Path) -> None:
    start = without_hashes(shutil.copytree(fits / "standing", tmp_path / "standing"))
    fit = read_fit_folder(start)
    nipple = fit.rig.landmark_points(("nipple_L",)).positions(fit.vertices, fit.rig.faces)[0]
    inside = nipple + 0.4 * (fit.vertices[fit.rig.regions["breast_L"]].mean(axis=0) - nipple)
    result = json.loads((start / "result.json").read_text())
    found = {"name": "Label 2", "center": (inside / fit.metres_per_unit).tolist(), "radius_mm": 5.0}
    (start / "result.json").write_text(json.dumps(result | {"lesions": [found]}))
    drawing = json.loads((start / "drawing.json").read_text())
    (start / "drawing.json").write_text(json.dumps(drawing | {"shapes": [], "unit": "mm"}))
    out = tmp_path / "there.json"
    assert main(["transfer", "--from", str(start), "--to", str(fits / "supine"), "-o", str(out)]) == 0
    (lesion,) = json.loads(out.read_text())["lesions"]
    assert (lesion["name"], lesion["radius_mm"], lesion["carried"]) == ("Label 2", 5.0, True)


@pytest.mark.parametrize(
    ("wrong", "word"),
    [
        ({"items": [PLAN["items"][0]] * 2}, 'have the id "t"'),
        ({}, "items"),
    ],
)
def test_what_is_no_plan_is_one_sentence(
    fits: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], wrong: dict, word: str
) -> None:
    file = tmp_path / "plan.json"
    file.write_text(json.dumps({"schema": "breastrig/plan@1"} | wrong))
    ends = ["--from", str(fits / "standing"), "--to", str(fits / "supine")]
    assert main(["transfer", *ends, "--drawing", str(file), "-o", str(tmp_path / "out.json")]) == 2
    said = capsys.readouterr().err
    assert word in said
    assert said.count("\n") == 1
    assert main(["transfer", *ends, "--drawing", str(file), "--other-patient", "-o", str(tmp_path / "out.json")]) == 2
