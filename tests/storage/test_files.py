"""Files on the disk and in a store: the rest of the program cannot tell which.

The store is a folder that fsspec takes for one; what only S3 does is tried in tests/scale.
"""

import errno
from pathlib import Path

import pytest

from breastrig.core import scratch
from breastrig.core.errors import BadSettings
from breastrig.storage.deletion import delete_rows, finish_deletions
from breastrig.storage.file_journal import pending_removals, record_creation
from breastrig.storage.files import Files, fit_place, scan_place
from breastrig.storage.location import Location
from breastrig.storage.rows.scans import ScanRow, add_scan, get_scan
from breastrig.storage.storage import Storage
from breastrig.storage.store_files import StoreFiles


@pytest.fixture(autouse=True)
def own_scratch(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """A place for scratch folders that no other test uses."""
    monkeypatch.setattr(scratch.tempfile, "gettempdir", lambda: str(tmp_path))
    return tmp_path / f"breastrig-{scratch.os.getuid()}"


@pytest.fixture(params=["disk", "store"])
def storage(request: pytest.FixtureRequest, tmp_path: Path) -> Storage:
    files = None if request.param == "disk" else f"file://{tmp_path}/store/below"
    storage = Storage(Location(tmp_path / "data", files=files))
    storage.prepare()
    yield storage
    storage.close()


@pytest.fixture
def files(storage: Storage) -> Files:
    return storage.files


def keep(files: Files, place: str, **content: bytes) -> None:
    files.make(place)
    with files.writing(place) as draft:
        for name, one in content.items():
            (draft.folder / name).write_bytes(one)
        draft.keep()


def test_what_was_kept_is_found_and_read(files: Files) -> None:
    keep(files, scan_place("a"), first=b"one", second=b"")
    found = files.find(scan_place("a"), "first")
    assert found is not None
    with found.open() as file:
        assert (file.seek(1), file.read(), found.size) == (1, b"ne", 3)
    with files.reading(scan_place("a")) as folder:
        assert {path.name: path.read_bytes() for path in folder.iterdir()} == {"first": b"one", "second": b""}
    with files.reading(scan_place("a"), ["first", "third"]) as folder:
        assert (folder / "first").read_bytes() == b"one"
        assert not (folder / "third").exists()


def test_what_is_not_there_is_not_found(files: Files) -> None:
    assert files.find(fit_place("nobody"), "result.json") is None
    keep(files, fit_place("a"), first=b"one")
    assert files.find(fit_place("a"), "second") is None


def test_another_content_has_another_etag(files: Files) -> None:
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


def test_removing_leaves_nothing_and_twice_is_no_error(files: Files, tmp_path: Path) -> None:
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


def test_a_draft_that_is_not_kept_is_not_in_the_store(tmp_path: Path, own_scratch: Path) -> None:
    files = StoreFiles(f"file://{tmp_path}/store")
    with files.writing(fit_place("a")) as draft:
        (draft.folder / "first").write_bytes(b"one")
        assert files.find(fit_place("a"), "first") is None
    assert files.find(fit_place("a"), "first") is None
    with files.writing(fit_place("a")) as draft:
        (draft.folder / "first").write_bytes(b"one")
        draft.keep()
        draft.take_back()
    assert files.find(fit_place("a"), "first") is None
    assert list(own_scratch.iterdir()) == []


def test_on_the_disk_nothing_is_copied(tmp_path: Path) -> None:
    storage = Storage(tmp_path / "data")
    storage.prepare()
    storage.make_fit("a")
    with storage.files.writing(fit_place("a")) as draft, storage.files.reading(fit_place("a")) as folder:
        assert draft.folder == folder == storage.folders.fit("a")
    storage.close()


def test_the_way_to_the_server_is_the_same_whatever_the_files_are(storage: Storage) -> None:
    add_scan(storage, ScanRow("scan-1", "2026-01-01T00:00:00.000Z", "ply", "ab" * 32, {}))
    storage.make_fit("fit-1")
    with storage.held("fit-1"):
        assert not storage.wait_until_free("fit-1", 0.02)
    assert storage.wait_until_free("fit-1", 0.02)
    storage.remove(fit_place("fit-1"))
    assert storage.wait_until_free("fit-1", 0.02)


@pytest.mark.parametrize(
    ("url", "sentence"),
    [
        ("nosuch://bucket/prefix", "Protocol not known: nosuch"),
        ("file:///proc/nothing/here", "The files at file:///proc/nothing/here cannot be reached"),
    ],
)
def test_a_store_that_is_none_gives_a_sentence(url: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(BadSettings, match=sentence) as refused:
        Storage(Location(tmp_path / "data", files=url)).prepare()
    assert "\n" not in str(refused.value)


def test_without_fsspec_the_sentence_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "fsspec.core", None)
    with pytest.raises(BadSettings, match=r"pip install 'breastrig\[s3\]'"):
        StoreFiles("s3://bucket/prefix")


def test_a_store_that_does_not_answer_is_an_error_of_the_system(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def silent(*_asked: object, **_more: object) -> None:
        raise RuntimeError("some library's own error")

    files = StoreFiles(f"file://{tmp_path}/store")
    for verb in ("info", "pipe_file", "find", "rm", "ls"):
        monkeypatch.setattr(files._fs, verb, silent)
    for act in (
        lambda: files.find(fit_place("a"), "b"),
        lambda: files.write(fit_place("a"), "b", b""),
        lambda: files.reading(fit_place("a")).__enter__(),
        lambda: files.remove(fit_place("a")),
        files.is_empty,
    ):
        with pytest.raises(OSError, match=r"does not answer \(RuntimeError\)") as error:
            act()
        assert error.value.errno == errno.EIO
