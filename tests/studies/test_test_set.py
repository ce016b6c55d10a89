"""The test set is measured by `evaluate --test` alone, once for each commit, and a log says what was found."""

import json
from pathlib import Path

import pytest

from breastrig.cli.main import main
from breastrig_studies import command
from breastrig_studies.studies import registry
from breastrig_studies.studies.trust.asked import asked

RIGHT = {"level": "good", "reasons": [], "error_mm": 3.0, "stance": "standing", "unclear": False}
FAR = {"level": "check", "reasons": ["Far."], "error_mm": 18.0, "stance": "standing", "unclear": True}
REFUSED = {"level": "refused", "reasons": ["This does not look like a torso."]}


def answer(*_: object) -> dict[str, object]:
    return {"all": RIGHT, "none": FAR, "one_wrong": RIGHT, "larger": REFUSED}


answer.__module__ = asked.__module__  # by which answers are kept


def test_a_test_set_is_looked_at_once_for_each_commit(
    cohort: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (cohort / "patient_x" / "patient.json").write_text(json.dumps({"half": "test", "family": "makehuman"}))
    monkeypatch.setitem(registry.ANSWERS, "asked", answer)
    monkeypatch.setattr(command, "commit", lambda: "abc1234")
    log = tmp_path / "test_set.md"
    look = ["evaluate", str(cohort), "--jobs", "1", "-o", str(tmp_path / "out")]
    assert main(look) == 2
    assert "only patients of a test set" in capsys.readouterr().err
    look += ["--test", str(log)]
    assert main(look) == 0
    first = log.read_text().splitlines()
    assert first[-1] == capsys.readouterr().out.strip()
    cells = [cell.strip() for cell in first[-1].strip("|").split("|")]
    # one stands, one lies and was called standing: clearly with all landmarks, not clearly without
    assert cells[1] == "abc1234"
    assert cells[3:] == [
        *("cohort", "1", "2", "100 % of 2", "33 % of 6", "50 % of 2, 0 of 1", "50 % of 2, 1 of 1", "3.0 / 18.0")
    ]
    assert main(look) == 2
    assert "abc1234 already" in capsys.readouterr().err
    assert main([*look, "--again"]) == 0
    assert log.read_text().splitlines() == [*first, first[-1]]
