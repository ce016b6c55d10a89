"""Files are removed only by a server whose database they belong to."""

import shutil
from pathlib import Path

import pytest

from breastrig.cli.main import main
from breastrig.core.errors import BadSettings
from breastrig.storage.storage import Storage


def prepared(root: Path) -> None:
    storage = Storage(root)
    try:
        storage.prepare()
    finally:
        storage.close()


def test_files_of_another_database_are_refused_and_stay(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("one", "two"):
        prepared(tmp_path / name)
    (tmp_path / "one" / "scans" / "a").mkdir()
    shutil.copy(tmp_path / "two" / "breastrig.sqlite3", tmp_path / "one" / "breastrig.sqlite3")
    with pytest.raises(BadSettings, match="belong to another database"):
        prepared(tmp_path / "one")
    assert main(["purge", "--all", "--data", str(tmp_path / "one")]) == 2
    assert "belong to another database" in capsys.readouterr().err
    assert (tmp_path / "one" / "scans" / "a").is_dir()


def test_a_data_folder_whose_database_was_lost_is_not_emptied(tmp_path: Path) -> None:
    prepared(tmp_path)
    (tmp_path / "scans" / "a").mkdir()
    for file in tmp_path.glob("breastrig.sqlite3*"):
        file.unlink()
    with pytest.raises(BadSettings, match="belong to another database"):
        prepared(tmp_path)
    assert (tmp_path / "scans" / "a").is_dir()


def test_a_place_that_is_gone_is_noticed(tmp_path: Path) -> None:
    storage = Storage(tmp_path / "one")
    assert not storage.has_files()
    storage.prepare()
    assert storage.has_files()
    (tmp_path / "one" / "installation").unlink()
    assert not storage.has_files()
    storage.close()
