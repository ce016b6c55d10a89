"""Plans and drawings of another patient in the same frame: asked about at the command line and in Python."""

import json
import shutil
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest
from helpers.example_fits import write_example_fits
from helpers.other_body import with_other_body
from helpers.results import write_patient

import breastrig
from breastrig.cli.main import main
from breastrig.core.errors import NeedsYes
from breastrig.drawings.drawing_schema import GivenDrawing
from breastrig.use.folder.fit_folder import read_fit_folder
from breastrig.use.folder.whose import check_whose
from breastrig.use.reports.report import laid_plan


@pytest.fixture(scope="module")
def fits(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fits")
    write_example_fits(folder)
    for stance in ("standing", "supine"):
        write_patient(folder / stance, "K7M-4QX", None)
    return folder


def line(fits: Path) -> dict[str, Any]:
    shape = json.loads((fits / "standing" / "drawing.json").read_text())["shapes"][0]
    return {key: shape[key] for key in ("name", "closed", "points", "bridged")}


def documents(fits: Path) -> dict[str, dict[str, Any]]:
    """The same lines and a tumour in this frame, as files name them."""
    mm = {"points": [[1e3 * value for value in point] for point in line(fits)["points"]]}
    item = line(fits) | mm | {"kind": "line", "id": "a"}
    tumour = {"kind": "tumour", "id": "t", "side": "L", "clock": 10, "distance_mm": 45, "radius_mm": 12}
    plan = {"schema": "breastrig/plan@1", "items": [item, tumour]}
    drawing = {"schema": "breastrig/drawing@1", "unit": "m", "shapes": [line(fits)]}
    scan = {"id": "s", "stance": "standing", "sha256": "ab" * 32}
    own = json.loads((fits / "standing" / "result.json").read_text())["scan"]["sha256"]
    return {
        "another's plan": plan | {"patient": "P-9", "scans": [scan]},
        "a plan of another scan": plan | {"scans": [scan]},
        "another's plan without scans": plan | {"patient": "P-9"},
        "another's drawing": drawing | {"patient": "P-9", "scan_sha256": "ab" * 32},
        "a drawing of another scan": drawing | {"scan_sha256": "ab" * 32},
        "own plan": plan | {"patient": "K7M-4QX", "scans": [scan]},
        "own scan's plan": plan | {"patient": "P-9", "scans": [scan | {"sha256": own}]},
        "own drawing": drawing | {"patient": "K7M-4QX", "scan_sha256": own},
        "an earlier version's plan": plan,
    }


NAMED = {  # whether it is this patient's as far as it says
    "another's plan": False,
    "a plan of another scan": False,
    "another's plan without scans": False,
    "another's drawing": False,
    "a drawing of another scan": False,
    "own plan": True,
    "own scan's plan": True,
    "own drawing": True,
    "an earlier version's plan": True,
}


def commands(fits: Path, file: Path, out: Path) -> list[list[str]]:
    standing, supine = str(fits / "standing"), str(fits / "supine")
    return [
        ["transfer", "--from", standing, "--to", supine, "--drawing", str(file), "-o", str(out / "there.json")],
        ["export", standing, "--plan", str(file), "-o", str(out / "exported")],
        ["report", standing, "--plan", str(file), "-o", str(out / "report")],
    ] + ([] if "plan" in file.name else [["compare", str(file), str(file), "--on", standing, "-o", str(out / "c")]])


@pytest.mark.parametrize("name", ["another's plan", "another's drawing"])
def test_anothers_plan_or_drawing_is_asked_about_at_every_door(
    name: str, fits: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / ("plan.json" if "plan" in name else "drawing.json")
    file.write_text(json.dumps(documents(fits)[name]))
    for command in commands(fits, file, tmp_path):
        assert main(command) == 2, command
        said = capsys.readouterr().err
        assert said.count("\n") == 1
        assert "add --same-patient." in said
        assert "for patient P-9, not for patient K7M-4QX" in said
        assert not Path(command[-1]).exists()
    with pytest.raises(NeedsYes, match="say same_patient"):
        breastrig.transfer(fits / "standing", fits / "supine", file)
    assert main([*commands(fits, file, tmp_path)[0], "--same-patient"]) == 0


@pytest.mark.parametrize("name", NAMED)
def test_a_file_is_asked_about_where_neither_scan_nor_patient_are_its_own(name: str, fits: Path) -> None:
    document, result = documents(fits)[name], breastrig.Fit.load(fits / "standing").in_metres.result
    with nullcontext() if NAMED[name] else pytest.raises(NeedsYes, match="for patient K7M-4QX") as asked:
        check_whose(document, [result], same_patient=False)
    if asked is not None:
        assert ("P-9" in str(asked.value)) is ("patient" in document)
        check_whose(document, [result], same_patient=True)


def test_what_is_carried_says_whose_it_is(fits: Path, tmp_path: Path) -> None:
    standing, supine, out = str(fits / "standing"), str(fits / "supine"), tmp_path / "there.json"
    (tmp_path / "own.json").write_text(json.dumps(documents(fits)["own plan"]))
    command = ["transfer", "--from", standing, "--to", supine, "--drawing", str(tmp_path / "own.json")]
    assert main([*command, "-o", str(out)]) == 0
    carried = json.loads(out.read_text())
    assert carried["patient"] == "K7M-4QX"
    assert carried["scan_sha256"] == json.loads((fits / "supine" / "result.json").read_text())["scan"]["sha256"]


def test_a_fit_s_drawing_says_whose_it_is_and_stays_the_fits_own(fits: Path, tmp_path: Path) -> None:
    drawing = GivenDrawing.model_validate_json((fits / "standing" / "drawing.json").read_bytes())
    result = breastrig.Fit.load(fits / "standing").in_metres.result
    assert (drawing.patient, drawing.scan_sha256) == ("K7M-4QX", result.scan.sha256)


def test_lines_a_little_off_the_skin_are_moved_onto_it_and_others_are_refused(
    fits: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Import took 50 mm and transfer 5: one limit, 10 mm."""
    standing, supine = str(fits / "standing"), str(fits / "supine")
    for off, code in ((0.008, 0), (0.012, 2)):
        shape = line(fits)
        shape["points"] = [[x, y, z + off] for x, y, z in shape["points"]]
        file = tmp_path / f"{off}.json"
        file.write_text(json.dumps({"schema": "breastrig/drawing@1", "unit": "m", "shapes": [shape]}))
        out = str(tmp_path / f"{off}.out.json")
        assert main(["transfer", "--from", standing, "--to", supine, "--drawing", str(file), "-o", out]) == code
    assert "away from the scan" in capsys.readouterr().err
    shutil.rmtree(tmp_path)


def test_a_plans_line_far_off_its_own_scan_is_left_out_and_it_is_said(fits: Path) -> None:
    fit = read_fit_folder(fits / "standing")
    near = {"points": [[1e3 * x, 1e3 * y, 1e3 * z] for x, y, z in line(fits)["points"]], "name": "near"}
    far = near | {"points": [[x, y, z + 40.0] for x, y, z in near["points"]], "name": "far"}
    items = [line(fits) | each | {"kind": "line", "id": each["name"]} for each in (near, far)]
    [(laid, _)] = laid_plan(fit.rig, {"schema": "breastrig/plan@1", "items": items}, [fit])
    assert [shape["item"] for shape in laid["shapes"]] == ["near"]
    [missing] = laid["missing"]
    assert missing["item"] == "far"
    assert missing["reason"].startswith('Point 1 of "far" is 32 mm away from the scan')


def test_scans_that_do_not_look_like_one_patients_are_asked_about_at_every_door(
    fits: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("standing", "supine"):
        shutil.copytree(fits / name, tmp_path / name)
    with_other_body(tmp_path / "supine")
    standing, supine, out = tmp_path / "standing", tmp_path / "supine", tmp_path / "out"
    plan = tmp_path / "plan.json"
    plan.write_text(json.dumps(documents(fits)["an earlier version's plan"]))
    for command in (
        ["transfer", "--from", str(standing), "--to", str(supine), "-o", str(out / "there.json")],
        ["report", str(standing), "--with", str(supine), "--plan", str(plan), "-o", str(out / "report")],
        ["export", str(supine), "--with", str(standing), "--plan", str(plan), "-o", str(out / "exported")],
    ):
        out.mkdir(exist_ok=True)
        assert main(command) == 2, command
        said = capsys.readouterr().err
        assert "These do not look like scans of one patient: " in said
        assert "add --same-patient." in said
        assert list(out.iterdir()) == []
    assert breastrig.transfer(standing, supine, same_patient=True).document["doubts"]
