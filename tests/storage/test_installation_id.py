"""Files are removed only by a server whose database they belong to."""

from pathlib import Path

import pytest

from breastrig.cli.main import main
from breastrig.core.errors import BadSettings
from breastrig.storage.files import scan_place
from breastrig.storage.location import Location
from breastrig.storage.storage import Storage


def prepared(location: Location) -> None:
    storage = Storage(location)
    try:
        storage.prepare()
    finally:
        storage.close()


@pytest.fixture
def store(tmp_path: Path) -> str:
    return f"file://{tmp_path}/store"


def test_files_of_another_database_are_refused_and_stay(
    tmp_path: Path, store: str, capsys: pytest.CaptureFixture[str]
) -> None:
    prepared(Location(tmp_path / "one", files=store))
    kept = Storage(Location(tmp_path / "one", files=store))
    kept.files.write(scan_place("a"), "scan.ply", b"skin")
    prepared(kept.location)
    with pytest.raises(BadSettings, match="belong to another database"):
        prepared(Location(tmp_path / "two", files=store))
    assert main(["purge", "--all", "--data", str(tmp_path / "two"), "--files", store]) == 2
    assert "belong to another database" in capsys.readouterr().err
    assert kept.files.find(scan_place("a"), "scan.ply") is not None
    kept.close()


def test_files_that_are_there_already_are_no_new_databases(tmp_path: Path, store: str) -> None:
    foreign = Storage(Location(tmp_path / "one", files=store))
    foreign.files.write(scan_place("a"), "scan.ply", b"skin")
    with pytest.raises(BadSettings, match="holds files but no mark of BreastRig, so it is left as it is"):
        foreign.prepare()
    assert [path.name for path in (tmp_path / "store").rglob("*") if path.is_file()] == ["scan.ply"]
    assert foreign.files.find(scan_place("a"), "scan.ply") is not None
    foreign.close()


def test_a_data_folder_whose_database_was_lost_is_not_emptied(tmp_path: Path) -> None:
    prepared(Location(tmp_path))
    (tmp_path / "scans" / "a").mkdir()
    for file in tmp_path.glob("breastrig.sqlite3*"):
        file.unlink()
    with pytest.raises(BadSettings, match="belong to another database"):
        prepared(Location(tmp_path))
    assert (tmp_path / "scans" / "a").is_dir()


def test_a_place_that_is_gone_is_noticed(tmp_path: Path, store: str) -> None:
    for location in (Location(tmp_path / "one"), Location(tmp_path / "two", files=store)):
        storage = Storage(location)
        assert not storage.has_files()
        storage.prepare()
        assert storage.has_files()
        for mark in (tmp_path / "one" / "installation", tmp_path / "store" / "installation"):
            mark.unlink(missing_ok=True)
        assert not storage.has_files()
        storage.close()
