"""Each study that is a program says how it is started, and refuses in one line what does not fit."""

import re
import runpy
from pathlib import Path

import pytest

STUDIES = Path(__file__).resolve().parents[2] / "server/breastrig_studies"
PROGRAMS = sorted(file for file in STUDIES.rglob("*.py") if '__name__ == "__main__"' in file.read_text("utf-8"))


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda file: file.stem)
def test_a_study_says_what_it_takes(
    program: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for given, status in (["--help"], 0), (["--no-such-option"], 2):
        monkeypatch.setattr("sys.argv", [program.name, *given])
        with pytest.raises(SystemExit) as ended:
            runpy.run_path(str(program), run_name="__main__")
        said = capsys.readouterr()
        assert ended.value.code == status
        assert re.match(rf"usage: {program.name} \[-h\]( \S+)*\n", said.out or said.err)
