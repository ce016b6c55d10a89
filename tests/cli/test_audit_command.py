"""`breastrig audit` prints and checks the log that `case` and `purge` write on a data folder."""

import json
import os
from pathlib import Path

import pytest
from helpers.cases import data_folder, new_case, new_scan
from pypdf import PdfReader

from breastrig.audit.read import lines_from
from breastrig.cli.main import main


def test_the_command_line_writes_and_reads_the_log(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = tmp_path / "data"
    case = new_case(data_folder(data))
    scans = sorted([new_scan(case), new_scan(case)])
    assert main(["case", "create", str(data), "--code", "Maria M."]) == 0
    other = Path(capsys.readouterr().out.split(" in ")[1].strip())
    assert main(["case", "rename", str(case.path), "--code", "Maria O."]) == 0
    assert main(["case", "plan", str(case.path), "-o", str(tmp_path / "plan.json")]) == 0
    assert main(["case", "show", str(case.path)]) == 0
    assert main(["case", "list", str(data)]) == 0
    assert main(["case", "move", str(case.path), str(other), "--scan", "1"]) == 0
    assert main(["case", "delete", str(other), "--scan", "1"]) == 0
    assert main(["purge", "--all", "--data", str(data)]) == 0
    assert main(["case", "create", str(tmp_path / "alone")]) == 0  # no data folder, no log
    found = [line for line in lines_from(data) if line["what"] != "begin"][::-1]
    mine, its = {"patient": case.id}, {"patient": other.name}
    moved, target = mine | {"scan": scans[0], "to_patient": other.name}, its | {"scan": scans[0]}
    assert [(line["what"], line["how"], line.get("of", {})) for line in found] == [
        ("change", "case create", {}),
        ("done", "case create", its),
        ("change", "case rename", mine),
        ("export", "case plan", mine),
        ("open", "case show", mine),
        ("open", "case list", {}),
        ("change", "case move", moved),
        ("delete", "case delete", target),
        ("done", "case delete", target),
        ("delete", "purge", mine),
        ("done", "purge", mine),
    ]
    assert {line["who"] for line in found} == {f"shell:{os.getuid()}"}
    assert found[7]["removes"]["case"]  # the case went with its last scan
    assert "Maria" not in json.dumps(found)
    capsys.readouterr()

    assert main(["audit", "list", str(data), "--of", other.name, "--last", "2"]) == 0
    printed = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line["what"] for line in printed] == ["delete", "done"]
    assert main(["audit", "list", str(data), "--since", "2999-01-01"]) == 0
    assert main(["audit", "certificate", str(data), case.id, "-o", str(tmp_path / "deleted.pdf")]) == 0
    assert (tmp_path / "deleted.pdf").read_bytes().startswith(b"%PDF")
    german = ["--language", "de", "--force", "-o", str(tmp_path / "deleted.pdf")]
    assert main(["audit", "certificate", str(data), case.id, *german]) == 0
    assert PdfReader(tmp_path / "deleted.pdf").pages[0].extract_text().startswith("Bescheinigung einer Löschung")
    assert main(["audit", "certificate", str(data), "x" * 22, "-o", str(tmp_path / "none.pdf")]) == 2
    assert "has no deletion of this id" in capsys.readouterr().err
    assert main(["audit", "check", str(data)]) == 0
    said = capsys.readouterr().out
    assert said.startswith("12 lines, as they were written; the last is 12:")
    anchor = said.split()[-1]
    assert main(["audit", "check", str(data), "--anchor", anchor]) == 0
    [file] = (data / "audit").glob("*.jsonl")
    file.write_bytes(file.read_bytes().replace(b'"case rename"', b'"case remove"'))
    capsys.readouterr()
    assert main(["audit", "check", str(data)]) == 1
    assert capsys.readouterr().out.startswith("Line 4 was changed")
    assert main(["audit", "check", str(tmp_path)]) == 2
    assert "no BreastRig data folder" in capsys.readouterr().err


def test_what_cannot_be_written_is_not_changed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = tmp_path / "data"
    case = new_case(data_folder(data), "K7M-4QX")
    new_scan(case)
    (data / "audit").write_text("in the way")
    assert main(["case", "rename", str(case.path), "--code", "other"]) == 2
    assert "cannot be written (File exists), so nothing was changed" in capsys.readouterr().err
    assert case.document().code == "K7M-4QX"
    assert main(["case", "list", str(data)]) == 0  # a folder that can only be read can be read
    assert "the audit log cannot be written" in capsys.readouterr().err
