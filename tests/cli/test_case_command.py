"""`breastrig case`: every action by its words, its exit codes, and what it says."""

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.cases import data_folder, new_case, new_scan

import breastrig
from breastrig.cli.main import main
from breastrig.core.assets import asset_folder

STANDING = asset_folder("example") / "standing"


@pytest.mark.slow
def test_from_a_file_to_a_plan_and_back(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case, plan = str(tmp_path / "her"), tmp_path / "plan.json"
    assert main(["case", "create", case, "--code", "K7M-4QX"]) == 0
    assert main(["case", "add", case, str(STANDING / "scan.ply")]) == 0
    assert "scan 1:" in capsys.readouterr().out
    assert main(["case", "landmarks", case, str(STANDING / "landmarks.json")]) == 0
    assert main(["case", "fit", case, "--drawing", "none"]) == 0
    assert main(["case", "predict", case, "--stance", "supine"]) == 0
    assert "supine, predicted from" in capsys.readouterr().out
    assert main(["case", "plan", case, "-o", str(plan)]) == 0
    document = json.loads(plan.read_text())
    assert (document["patient"], document["version"], document["items"]) == ("K7M-4QX", 0, [])
    drawn = {"schema": "breastrig/drawing@1", "unit": "mm", "shapes": [{"name": "cut", "points": [[0, 0, 100]]}]}
    plan.write_text(json.dumps(drawn))
    assert main(["case", "plan", case, "--put", str(plan)]) == 2  # no guess on which scan it was drawn
    assert "does not say on which scan" in capsys.readouterr().err
    assert main(["case", "plan", case, "--put", str(plan), "--scan", "1", "--same-patient"]) == 0
    assert main(["case", "plan", case, "--put", str(plan), "--scan", "1", "--seen", "0"]) == 2
    assert "Somebody has changed this" in capsys.readouterr().err
    assert main(["case", "plan", case, "--undo", "1"]) == 0
    assert capsys.readouterr().out == "version 2\n"
    assert main(["case", "plan", case, "-o", str(plan)]) == 2  # not over a file that is there
    assert main(["case", "plan", case, "-o", str(plan), "--force", "--version", "1"]) == 0
    capsys.readouterr()
    assert main(["case", "show", case]) == 0
    said = capsys.readouterr().out
    assert said.startswith("K7M-4QX   plan: version 2, 1 items, seen ")
    assert "done, good, standing" in said
    assert main(["case", "add", case, str(STANDING / "scan.ply")]) == 2
    assert "--again" in capsys.readouterr().err
    assert main(["case", "delete", case, "--scan", "1"]) == 0
    assert not Path(case).exists()


def test_scans_are_named_by_number_or_id_and_never_guessed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cases = data_folder(tmp_path)
    case, other = new_case(cases, "A"), new_case(cases, "B")
    scans = [new_scan(case), new_scan(case)]
    assert main(["case", "move", str(case.path), str(other.path)]) == 2
    assert "say which with --scan" in capsys.readouterr().err
    assert main(["case", "move", str(case.path), str(other.path), "--scan", "3"]) == 2
    assert main(["case", "move", str(case.path), str(other.path), "--scan", scans[0]]) == 0
    assert other.scan_ids() == {scans[0]}
    assert main(["case", "list", str(tmp_path)]) == 0
    assert [line.split()[0] for line in sorted(capsys.readouterr().out.splitlines())] == ["A", "B"]
    assert main(["case", "rename", str(other.path), "--code", "C"]) == 0
    assert breastrig.Case(other.path).code == "C"
    assert main(["case", "delete", str(other.path), "--all"]) == 0
    assert not other.path.exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["show", "NOWHERE"], "There is no case at"),
        (["list", "NOWHERE"], "There is no folder"),
        (["fit", "CASE"], "has no scan yet"),
        (["predict", "CASE", "--stance", "prone"], "has no scan yet"),
        (["create", "CASE"], "is there already"),
        (["plan", "CASE", "-o", "x.json", "--seen", "0"], "belong to --put and --undo"),
        (["plan", "CASE", "--undo", "7"], "not kept any more"),
        (["plan", "CASE", "--undo", "7", "--version", "1"], "belong to -o"),
        (["plan", "CASE", "--put", "NOWHERE"], "that can be read"),
        (["plan", "CASE", "--put", "CASE/case.json"], "no plan"),
        (["rename", "CASE", "--code", "a\u200bb"], "characters that nobody sees"),
    ],
)
def test_what_is_wrong_is_one_sentence(
    words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = breastrig.Case.create(tmp_path / "case")
    places = {"NOWHERE": str(tmp_path / "nowhere"), "CASE": str(case.path), "CASE/case.json": f"{case.path}/case.json"}
    assert main(["case", *(places.get(word, word) for word in words)]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_landmarks_of_a_scan_that_has_a_length_are_said_to_be_in_its_size(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case, picks = breastrig.Case.create(tmp_path / "hers"), json.loads((STANDING / "landmarks.json").read_text())
    scan = case.add_scan(STANDING / "scan.ply")
    words = ["case", "landmarks", str(case.path), str(STANDING / "landmarks.json")]
    assert main(words) == 0
    assert capsys.readouterr().err == ""
    start, end = (np.array(picks["landmarks"][name]) for name in ("nipple_L", "xiphoid"))
    per_mm = {"m": 1e3, "mm": 1.0}[picks["unit"]]
    case.put_length(scan, "nipple_L", "xiphoid", 1.03 * per_mm * float(np.linalg.norm(start - end)))
    assert main(words) == 0
    assert "true size of this scan, 1.030 times that of its own file" in capsys.readouterr().err
