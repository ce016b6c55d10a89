"""Files of scans and fits in the data folder."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from breastrig.storage.deletion import delete_rows, finish_deletions
from breastrig.storage.file_journal import pending_removals, record_creation
from breastrig.storage.files import fit_place, scan_place
from breastrig.storage.folders import Folders
from breastrig.storage.rows.scans import ScanRow, add_scan, get_scan
from breastrig.storage.storage import Storage


@pytest.fixture
def storage(tmp_path: Path) -> Iterator[Storage]:
    storage = Storage(tmp_path / "data")
    storage.prepare()
    yield storage
    storage.close()


@pytest.fixture
def files(storage: Storage) -> Folders:
    return storage.files


def keep(files: Folders, place: str, **content: bytes) -> None:
    files.make(place)
    for name, one in content.items():
        (files.folder(place) / name).write_bytes(one)


def test_what_was_kept_is_found_and_read(files: Folders) -> None:
    keep(files, scan_place("a"), first=b"one", second=b"")
    found = files.find(scan_place("a"), "first")
    assert found is not None
    with found.open() as file:
        assert (file.seek(1), file.read(), found.size) == (1, b"ne", 3)
    folder = files.folder(scan_place("a"))
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == {"first": b"one", "second": b""}


def test_what_is_not_there_is_not_found(files: Folders) -> None:
    assert files.find(fit_place("nobody"), "result.json") is None
    keep(files, fit_place("a"), first=b"one")
    assert files.find(fit_place("a"), "second") is None


def test_another_content_has_another_etag(files: Folders) -> None:
    keep(files, fit_place("a"), first=b"one")
    etags = []
    for content in (b"two", b"four", b"five"):
        files.write(fit_place("a"), "first", content)
        found = files.find(fit_place("a"), "first")
        assert found is not None
        with found.open() as file:
            assert file.read() == content
        etags.append(found.etag)
    assert len(set(etags)) == 3


def test_removing_leaves_nothing_and_twice_is_no_error(files: Folders, tmp_path: Path) -> None:
    keep(files, scan_place("a"), first=b"skin of a")
    keep(files, scan_place("b"), first=b"skin of b")
    for place in (scan_place("a"), scan_place("a"), fit_place("nobody")):
        files.remove(place)
    left = [path.read_bytes() for path in tmp_path.rglob("first")]
    assert left == [b"skin of b"]
    assert files.find(scan_place("a"), "first") is None


def test_files_that_no_row_has_ever_named_are_counted_and_stay(
    storage: Storage, caplog: pytest.LogCaptureFixture
) -> None:
    add_scan(storage, ScanRow("known", "2026-01-01T00:00:00.000Z", "ply", "ab" * 32, {}))
    for place in (scan_place("known"), scan_place("unknown"), fit_place("unknown")):
        keep(storage.files, place, first=b"one")
    assert finish_deletions(storage) == []
    for place in (scan_place("known"), scan_place("unknown"), fit_place("unknown")):
        assert storage.files.find(place, "first") is not None
    assert [record.getMessage() for record in caplog.records] == [
        "2 files or folders among those of scans and fits are none of BreastRig's; they stay"
    ]


def test_what_a_killed_server_was_making_or_removing_is_removed_at_the_next_start(
    storage: Storage, caplog: pytest.LogCaptureFixture
) -> None:
    add_scan(storage, ScanRow("kept", "2026-01-01T00:00:00.000Z", "ply", "ab" * 32, {}))
    add_scan(storage, ScanRow("deleted", "2026-01-01T00:00:00.000Z", "ply", "ab" * 32, {}))
    record_creation(storage, "upload", [scan_place("upload")])
    record_creation(storage, "kept", [fit_place("asked")])
    for place in map(scan_place, ("kept", "deleted", "upload")):
        keep(storage.files, place, first=b"one")
    keep(storage.files, fit_place("asked"), first=b"one")
    delete_rows(storage, "deleted")
    assert finish_deletions(storage) == []
    for place in (scan_place("upload"), scan_place("deleted"), fit_place("asked")):
        assert storage.files.find(place, "first") is None
    assert storage.files.find(scan_place("kept"), "first") is not None
    assert get_scan(storage, "kept").id == "kept"
    assert pending_removals(storage) == {}
    assert not caplog.records


def test_a_fit_is_held_by_one_and_waited_for(storage: Storage) -> None:
    add_scan(storage, ScanRow("scan-1", "2026-01-01T00:00:00.000Z", "ply", "ab" * 32, {}))
    storage.make_fit("fit-1")
    with storage.held("fit-1"):
        assert not storage.wait_until_free("fit-1", 0.02)
    assert storage.wait_until_free("fit-1", 0.02)
    storage.remove(fit_place("fit-1"))
    assert storage.wait_until_free("fit-1", 0.02)
