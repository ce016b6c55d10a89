"""`breastrig index DATA` says what it found, and refuses what is no data folder."""

from pathlib import Path

import pytest
from helpers.cases import data_folder, new_case, new_scan

from breastrig.cli.main import main


def test_it_says_what_it_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = tmp_path / "data"
    cases = data_folder(data)
    case = new_case(cases)
    new_scan(case)
    assert main(["index", str(data)]) == 0
    said = capsys.readouterr()
    assert said.out == "1 cases, 1 scans, 0 fits\n"
    assert "links are closed" in said.err
    assert main(["index", str(data)]) == 0
    assert capsys.readouterr().err == ""
    assert main(["case", "create", str(data), "--code", "K7M-4QX"]) == 0
    assert main(["index", str(data)]) == 0
    assert capsys.readouterr().out.endswith("\n2 cases, 1 scans, 0 fits\n")
    (case.path / "plan.json").write_text("{")
    assert main(["index", str(data)]) == 1
    assert f"the case {case.id} has a damaged document" in capsys.readouterr().err
    assert main(["index", str(tmp_path)]) == 2
    assert "no BreastRig data folder" in capsys.readouterr().err
