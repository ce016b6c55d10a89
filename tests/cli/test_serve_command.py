"""What keeps the service from starting is one sentence."""

from pathlib import Path

import pytest

from breastrig.cli.main import main


@pytest.mark.parametrize(
    ("option", "value", "sentence"),
    [
        ("--database", "postgresql://me:geheim@127.0.0.1:1/rig", "The database cannot be reached ("),
        ("--files", "nosuch://bucket", "Files cannot be kept at nosuch://bucket ("),
    ],
)
def test_a_place_that_cannot_be_used_is_named(
    option: str, value: str, sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["serve", "--port", "0", "--data", str(tmp_path / "data"), option, value]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"breastrig: {sentence}")
    assert said.count("\n") == 1
    assert "geheim" not in said
