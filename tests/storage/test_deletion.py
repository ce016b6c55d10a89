"""Deleting: on a full disk, interrupted at any step, and with files that cannot be removed."""

import os
import re
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from helpers.on_disk import bytes_below
from helpers.rows import add_waiting_fit
from sqlalchemy import event
from sqlalchemy.exc import OperationalError

from breastrig.cli.main import main
from breastrig.storage import reserve
from breastrig.storage.deletion import delete_scan, discard, finish_deletions, remove_files
from breastrig.storage.file_journal import count_pending_removals, pending_removals, record_creation
from breastrig.storage.files import fit_place, scan_place, share_place
from breastrig.storage.rows.fits import fit_ids
from breastrig.storage.rows.scans import ScanRow, add_scan, scan_ids
from breastrig.storage.rows.shares import ShareRow, add_share, end_snapshots, get_share
from breastrig.storage.storage import Storage, Unremoved

pytestmark = pytest.mark.long

FITS = [f"fit-{k}" for k in range(4)]
SHARE = ShareRow("share", "fit-0", "2026-01-01T00:00:00.000Z", "2999-01-01T00:00:00.000Z", "none", None, "shown", "")
TRACES = (b"skin of scan-1", b"result of fit-", b"scan-1", b"fit-0", b"fit-3", b"seen through a link", b"shares/shown")
WRITES = re.compile("INSERT|UPDATE|DELETE")


@pytest.fixture
def full(storage: Storage) -> Storage:
    """A scan with several fits and a link to one, files of all, and another scan."""
    for scan in ("scan-1", "scan-2"):
        storage.files.make(f"scans/{scan}")
        (storage.files.scan(scan) / "scan.ply").write_bytes(f"skin of {scan}".encode())
        add_scan(storage, ScanRow(scan, "2026-01-01T00:00:00.000Z", "ply", "ab" * 32, {}))
    for fit in FITS:
        storage.make_fit(fit)
        (storage.files.fit(fit) / "result.json").write_text(f"result of {fit}")
        add_waiting_fit(storage, "scan-1", fit)
    storage.files.make(share_place("shown"))
    storage.files.write(share_place("shown"), "plan.json", b"seen through a link")
    add_share(storage, SHARE, "cd" * 32)
    storage.refill_reserve()
    return storage


def test_what_links_show_stays_through_a_restart_and_goes_when_they_are_over(full: Storage) -> None:
    record_creation(full, "scan-1", [share_place("killed")])  # a server was killed while it made that one
    full.files.make(share_place("killed"))
    assert finish_deletions(full) == []
    assert full.files.find(share_place("killed"), "") is None
    assert full.files.find(share_place("shown"), "plan.json") is not None
    assert end_snapshots(full, "2998-12-31T00:00:00.000Z") == []
    assert end_snapshots(full, "2999-01-01T00:00:00.000Z") == ["scan-1"]
    assert remove_files(full, "scan-1") == []
    assert not list((full.root / "shares").iterdir())
    assert get_share(full, "fit-0", "share").snapshot is None


def assert_gone(storage: Storage) -> None:
    """Nothing is left of the one scan, all of the other."""
    assert (scan_ids(storage), fit_ids(storage), pending_removals(storage)) == ({"scan-2"}, set(), {})
    names = " ".join(path.as_posix() for path in storage.root.rglob("*")).encode()
    left = names + bytes_below(storage.root, "[!r]*") + bytes_below(storage.root, "[!r]*/**/*")  # not the reserve
    assert [trace for trace in TRACES if trace in left] == []
    assert (storage.files.scan("scan-2") / "scan.ply").read_bytes() == b"skin of scan-2"


@contextmanager
def before_statements(storage: Storage, act: Callable[[str, object], None]) -> Iterator[None]:
    def listen(_connection: object, _cursor: object, statement: str, parameters: object, *_more: object) -> None:
        act(statement, parameters)

    event.listen(storage.database.engine, "before_cursor_execute", listen)
    try:
        yield
    finally:
        event.remove(storage.database.engine, "before_cursor_execute", listen)


def disk_full(statement: str) -> OperationalError:
    """As it comes from SQLite."""
    error = sqlite3.OperationalError("database or disk is full")
    error.sqlite_errorname = "SQLITE_FULL"
    return OperationalError(statement, {}, error)


def test_a_full_disk_is_no_obstacle_as_there_is_a_reserve_and_it_is_filled_again(full: Storage) -> None:
    size = full.files.reserve.stat().st_size
    assert size == reserve.BYTES
    refused = []

    def act(statement: str, _parameters: object) -> None:
        if WRITES.match(statement) and full.files.reserve.stat().st_size > size - 2 * reserve.STEP:
            refused.append(statement)
            raise disk_full(statement)

    with before_statements(full, act):
        assert delete_scan(full, "scan-1") == []
    assert len(refused) == 3  # the first of all at once, and two before there was room enough
    assert_gone(full)
    assert full.files.reserve.stat().st_size == size


def test_without_a_reserve_a_full_disk_deletes_nothing_and_says_so(full: Storage) -> None:
    os.truncate(full.files.reserve, 0)

    def act(statement: str, _parameters: object) -> None:
        if WRITES.match(statement):
            raise disk_full(statement)

    with before_statements(full, act), pytest.raises(OperationalError):
        delete_scan(full, "scan-1")
    assert scan_ids(full) == {"scan-1", "scan-2"}
    assert (full.files.scan("scan-1") / "scan.ply").is_file()
    assert delete_scan(full, "scan-1") == []
    assert_gone(full)


class Killed(Exception):
    """Stands for the end of the process."""


@pytest.mark.parametrize("finish", [finish_deletions, remove_files])
@pytest.mark.parametrize("last", range(20))
def test_rows_too_many_for_the_reserve_are_deleted_in_steps_and_an_interrupted_step_is_made_up_for(
    full: Storage, last: int, finish: Callable[[Storage], list[Unremoved]]
) -> None:
    """However many of the steps come to pass before the server is killed or fails, its next start or look does the
    others."""
    done = []

    def act(statement: str, parameters: object) -> None:
        if statement.startswith("DELETE FROM fits") and statement.count("?") > 1:
            raise disk_full(statement)
        if statement.startswith("DELETE"):
            if len(done) == last:
                raise Killed
            done.append(statement)

    with before_statements(full, act):
        try:
            assert delete_scan(full, "scan-1") == []
        except Killed:
            assert "scan-1" in scan_ids(full) or count_pending_removals(full)
    if "scan-1" in scan_ids(full) and scan_place("scan-1") not in pending_removals(full):
        assert (full.files.scan("scan-1") / "scan.ply").is_file()  # killed before it had begun: all is as it was
        assert fit_ids(full) == set(FITS)
        assert delete_scan(full, "scan-1") == []
    assert finish(full) == []
    assert_gone(full)


@pytest.fixture
def refusing(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """`refusing(name)`: the system removes no file of that name any more; an empty name: it removes all again."""
    names = {""}
    unlink = os.unlink

    def refuse(path: str, **more: int) -> None:
        if Path(path).name in names:
            raise PermissionError(1, "Operation not permitted", path)
        unlink(path, **more)

    monkeypatch.setattr(os, "unlink", refuse)
    return lambda name: (names.clear(), names.add(name))[0]


def test_files_that_cannot_be_removed_are_known_until_they_are(
    full: Storage, refusing: Callable[[str], None], capsys: pytest.CaptureFixture[str]
) -> None:
    refusing("result.json")
    left = delete_scan(full, "scan-1")
    assert [one.place for one in left] == [fit_place(fit) for fit in FITS]
    assert {one.reason for one in left} == {"Operation not permitted"}
    assert [Path(one.where) for one in left] == [full.root / "rubbish" / f"fits.{fit}" for fit in FITS]
    assert all((Path(one.where) / "result.json").is_file() for one in left)
    assert scan_ids(full) == {"scan-2"}
    assert not list((full.root / "fits").iterdir())
    for again in (remove_files, finish_deletions):
        assert again(full) == left
    assert remove_files(full, "scan-2") == []
    assert main(["purge", "--older-than", "36500", "--data", str(full.root)]) == 1
    out, said = capsys.readouterr()
    assert out == f"0 scans deleted from {full.root}\n"
    assert said.splitlines() == [
        *(f"breastrig: {one.where} cannot be removed (Operation not permitted)" for one in left),
        "breastrig: 4 folders of deleted scans could not be removed; mend what is in the way and call purge again.",
    ]
    refusing("")
    assert main(["purge", "--older-than", "36500", "--data", str(full.root)]) == 0
    assert capsys.readouterr() == (f"0 scans deleted from {full.root}\n", "")
    assert_gone(full)


def test_a_folder_that_cannot_be_moved_is_removed_where_it_is(full: Storage, monkeypatch: pytest.MonkeyPatch) -> None:
    """Because the disk has no room for another name, or the folder is another disk."""

    def refuse(*_paths: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", refuse)
    assert delete_scan(full, "scan-1") == []
    assert_gone(full)


def test_what_is_being_made_is_not_removed_with_what_was_not_kept(full: Storage) -> None:
    """Two fits of one scan are asked for at once, and one of them is refused."""
    record_creation(full, "scan-2", [fit_place("refused")])
    record_creation(full, "scan-2", [fit_place("kept")])
    for fit in ("refused", "kept"):
        full.make_fit(fit)
    discard(full, "scan-2", fit_place("refused"))
    assert not full.files.fit("refused").exists()
    assert full.files.fit("kept").is_dir()
    add_waiting_fit(full, "scan-2", "kept")
    assert finish_deletions(full) == []
    assert full.files.fit("kept").is_dir()


def test_what_is_being_made_of_a_scan_that_is_deleted_is_removed(full: Storage) -> None:
    record_creation(full, "scan-1", [fit_place("asked")])
    full.make_fit("asked")
    assert delete_scan(full, "scan-1") == []
    assert not full.files.fit("asked").exists()
    assert_gone(full)


def test_a_scan_that_is_not_there_leaves_no_trace_of_its_name(full: Storage) -> None:
    assert delete_scan(full, "nobody-has-this-name") == []
    assert pending_removals(full) == {}
    assert b"nobody-has-this-name" not in bytes_below(full.root, "breastrig.sqlite3*")


def test_a_small_disk_gives_only_a_part_of_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    free = [2 * reserve.BYTES]
    monkeypatch.setattr(
        reserve.shutil, "disk_usage", lambda _path: reserve.shutil._ntuple_diskusage(16 * 2**20, 0, free[0])
    )
    aside = reserve.Reserve(tmp_path / "reserve")

    def size() -> int:
        return (tmp_path / "reserve").stat().st_size

    aside.refill()
    assert size() == 2 * 2**20  # an eighth
    assert [aside.release() for _ in range(5)] == [True] * 4 + [False]
    assert size() == 0
    free[0] = 2**20
    aside.refill()
    assert size() == 2**20  # what was given up, as far as it is there
    free[0] = 2**20
    aside.refill()
    assert size() == 3 * 2**19  # half of what is free
