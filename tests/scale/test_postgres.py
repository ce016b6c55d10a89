"""What PostgreSQL must do as SQLite does: order of writers, snapshots of readers, one server, one end of a fit."""

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from helpers.postgres_server import NONE_HERE, PostgresServer, programs
from helpers.rows import add_waiting_fit
from sqlalchemy import func, insert, select

from breastrig.cli.main import main
from breastrig.core.errors import BadInput, BadSettings, Conflict
from breastrig.core.picks import Picks
from breastrig.storage import postgres as database
from breastrig.storage import schema
from breastrig.storage.deletion import delete_rows, remove_files
from breastrig.storage.location import Location
from breastrig.storage.rows.events import append, events_after
from breastrig.storage.rows.fits import claim_fit, fits_page, get_fit, next_queued, queue_positions
from breastrig.storage.rows.scans import ScanRow, add_scan, get_landmarks, get_scan, put_landmarks
from breastrig.storage.rows.shares import (
    ShareRow,
    add_opening,
    add_share,
    end_visit,
    get_share,
    note_wrong_passcode,
    share_of_visit,
    unlock_share,
)
from breastrig.storage.storage import Storage

FACTS = {"unit": "mm", "bounds_m": {"min": [0, 0, 0], "max": [1, 1, 1]}}


@pytest.fixture(scope="module")
def url(postgres: PostgresServer) -> str:
    return postgres.new_database()


@pytest.fixture
def storage(url: str, tmp_path: Path) -> Iterator[Storage]:
    """The database of this file, emptied of what the last test left."""
    storage = Storage(Location(tmp_path / "data", url))
    storage.prepare()
    with storage.database.writing() as connection:
        connection.execute(schema.scans.delete())
        connection.execute(schema.patients.delete())
    add_scan(storage, ScanRow("scan-1", "2026-01-01T00:00:00.000Z", "ply", "ab" * 32, FACTS))
    yield storage
    storage.close()


def iterated(iteration: int) -> dict[str, object]:
    return {"kind": "iterated", "iteration": iteration, "nodes": []}


def test_the_revisions_make_the_tables_of_the_schema(storage: Storage) -> None:
    storage.prepare()
    with storage.database.reading() as connection:
        assert compare_metadata(MigrationContext.configure(connection), schema.metadata) == []


def test_a_database_of_a_newer_version_is_refused(
    postgres: PostgresServer, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    storage = Storage(Location(tmp_path, postgres.new_database()))
    storage.prepare()
    with storage.database.writing() as connection:
        connection.exec_driver_sql("UPDATE alembic_version SET version_num = '9999'")
    place = ["--data", str(tmp_path), "--database", str(storage.location.database)]
    assert main(["purge", "--all", *place]) == 2
    assert capsys.readouterr().err.startswith("breastrig: A newer BreastRig has used this database")
    storage.close()


def test_writers_wait_for_each_other_and_readers_for_nobody(storage: Storage) -> None:
    steps: list[str] = []
    inside = threading.Event()

    def second() -> None:
        inside.wait()
        with storage.database.writing():
            steps.append("second")

    thread = threading.Thread(target=second)
    thread.start()
    with storage.database.writing() as writer:
        inside.set()
        writer.execute(insert(schema.landmarks).values(scan="scan-1", points_mm="{}"))
        thread.join(timeout=0.1)
        assert get_landmarks(storage, "scan-1") == Picks({})
        with storage.database.reading() as reader:
            assert reader.execute(select(func.count()).select_from(schema.landmarks)).scalar_one() == 0
        assert not storage.database.can_write(0.05)
        steps.append("first")
    thread.join()
    assert steps == ["first", "second"]
    assert storage.database.can_write(5.0)


def test_a_reader_sees_one_state_and_can_write_nothing(storage: Storage) -> None:
    count = select(func.count()).select_from(schema.landmarks)
    with storage.database.reading() as reader:
        assert reader.execute(count).scalar_one() == 0
        put_landmarks(storage, "scan-1", Picks({}))
        assert reader.execute(count).scalar_one() == 0
    with storage.database.reading() as reader:
        assert reader.execute(count).scalar_one() == 1
        with pytest.raises(Exception, match="read-only transaction"):
            reader.execute(schema.landmarks.delete())


def test_whoever_sees_an_event_sees_all_before_it(storage: Storage) -> None:
    """Many write at once; the positions that a reader sees never lack one that comes later."""
    fits = [f"fit-{k}" for k in range(4)]
    for fit in fits:
        add_waiting_fit(storage, "scan-1", fit)
    over = threading.Event()
    seen: list[list[int]] = []

    def read() -> None:
        while not over.is_set():
            with storage.database.reading() as connection:
                seen.append(list(connection.execute(select(schema.events.c.position)).scalars()))

    def write(fit: str) -> None:
        for k in range(25):
            append(storage, fit, iterated(k))

    threads = [threading.Thread(target=write, args=(fit,)) for fit in fits]
    reader = threading.Thread(target=read)
    for thread in (reader, *threads):
        thread.start()
    for thread in threads:
        thread.join()
    over.set()
    reader.join()
    with storage.database.reading() as connection:
        everything = sorted(connection.execute(select(schema.events.c.position)).scalars())
    assert len(seen) > 1
    for positions in seen:
        assert sorted(positions) == everything[: len(positions)]
    for fit in fits:
        assert [event.number for event in events_after(storage, fit, 0)] == list(range(1, 26))


def test_a_fit_ends_once_however_many_end_it(storage: Storage) -> None:
    add_waiting_fit(storage, "scan-1", "fit-1")
    outcomes: list[str] = []

    def end(kind: str) -> None:
        try:
            append(storage, "fit-1", {"kind": kind, "reason": kind})
            outcomes.append(kind)
        except Conflict:
            outcomes.append("refused")

    threads = [threading.Thread(target=end, args=(kind,)) for kind in ("failed", "cancelled") * 3]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert outcomes.count("refused") == 5
    assert get_fit(storage, "fit-1").state in outcomes


def test_the_queue_and_its_claims(storage: Storage) -> None:
    for fit in ("fit-z", "fit-a"):
        add_waiting_fit(storage, "scan-1", fit)
    assert (next_queued(storage, set()), next_queued(storage, {"fit-z"})) == ("fit-z", "fit-a")
    assert queue_positions(storage, ["fit-z", "fit-a"]) == {"fit-z": 1, "fit-a": 2}
    claims = [claim_fit(storage, "fit-z") for _ in range(2)]
    assert [claim and claim.attempt for claim in claims] == [1, 2]
    with pytest.raises(Conflict, match="Another worker"):
        append(storage, "fit-z", iterated(0), attempt=1)
    assert append(storage, "fit-z", iterated(0), attempt=2) == 1
    assert [row.id for row in fits_page(storage, 10, scan_id="scan-1")[0]] == ["fit-a", "fit-z"]


def test_deleting_a_scan_leaves_no_row(storage: Storage) -> None:
    add_waiting_fit(storage, "scan-1", "fit-1")
    add_share(storage, ShareRow("share-1", "fit-1", "2026", "2027", "none", None, "shown", "2026"), "ab" * 32)
    for visit in ("cd" * 32, "ef" * 32):
        assert add_opening(storage, "share-1", "2026", visit, most_wrong=1)
    assert get_share(storage, "fit-1", "share-1").openings == 2
    put_landmarks(storage, "scan-1", Picks({"nipple_L": [1.0, 2.0, 3.0]}, ("nipple_L",)))
    append(storage, "fit-1", iterated(0))
    assert delete_rows(storage, "scan-1") == ["fit-1"]
    assert remove_files(storage, "scan-1") == []
    with storage.database.reading() as connection:
        for table in set(schema.metadata.tables.values()) - {schema.installation}:
            assert connection.execute(select(func.count()).select_from(table)).scalar_one() == 0, table.name


def test_visits_of_a_share_and_what_wrong_passcodes_do_to_it(storage: Storage) -> None:
    add_waiting_fit(storage, "scan-1", "fit-1")
    for share, token in (("share-1", "ab" * 32), ("share-2", "ba" * 32)):
        add_share(storage, ShareRow(share, "fit-1", "2026", "2027", "none", None, f"shown-{share}", "2026"), token)
    assert add_opening(storage, "share-1", "2026-02", "cd" * 32, most_wrong=2)
    found = share_of_visit(storage, "share-1", "cd" * 32, "2026-01")
    assert found is not None
    assert (found.id, found.openings) == ("share-1", 1)
    assert share_of_visit(storage, "share-2", "cd" * 32, "2026-01") is None
    assert share_of_visit(storage, "share-1", "cd" * 32, "2026-02") is None  # too old
    assert not end_visit(storage, "share-2", "cd" * 32)
    assert [end_visit(storage, "share-1", "cd" * 32) for _ in range(2)] == [True, False]
    assert share_of_visit(storage, "share-1", "cd" * 32, "2026-01") is None
    for moment in ("2026-03", "2026-04"):
        assert note_wrong_passcode(storage, "share-1", moment, 2)
    assert not note_wrong_passcode(storage, "share-1", "2026-05", 2)
    assert not add_opening(storage, "share-1", "2026-05", "ef" * 32, most_wrong=2)
    unlock_share(storage, "fit-1", "share-1")
    assert add_opening(storage, "share-1", "2026-05", "ef" * 32, most_wrong=2)
    row = get_share(storage, "fit-1", "share-1")
    assert (row.wrong_passcodes, row.last_wrong_at, row.openings, row.is_locked(2)) == (2, "2026-04", 2, False)


def test_a_fit_is_held_by_one_and_waited_for(storage: Storage) -> None:
    with storage.held("fit-1"):
        assert not storage.wait_until_free("fit-1", 0.02)
        assert storage.wait_until_free("fit-2", 0.02)
    assert storage.wait_until_free("fit-1", 1.0)


def test_a_fit_whose_lock_is_not_released_is_taken_over_after_a_while(
    url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(database, "BUSY_TIMEOUT_S", 0.05)
    storage = Storage(Location(tmp_path / "data", url))
    with storage.held("fit-1"), storage.held("fit-1"):
        assert not storage.wait_until_free("fit-1", 0.0)
    storage.close()


def test_a_value_that_cannot_be_stored_is_bad_input(storage: Storage) -> None:
    with pytest.raises(BadInput, match="cannot be stored"):
        get_scan(storage, "a\0b")


def test_what_is_wrong_with_a_database_is_said_in_a_sentence(
    storage: Storage, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(database, "CONNECT_TIMEOUT_S", 2)
    address = str(storage.location.database)
    password = address.split(":")[2].partition("@")[0]
    for wrong in (address.replace(password, "geheim"), address + "_other", "postgresql://me:geheim@127.0.0.1:1/rig"):
        with pytest.raises(BadSettings, match="The database cannot be reached") as refused:
            purge_nothing(Location(tmp_path / "new", wrong))
        assert not (tmp_path / "new").exists()
        assert "\n" not in str(refused.value)
        assert password not in str(refused.value)
        assert "geheim" not in str(refused.value)
    monkeypatch.setitem(__import__("sys").modules, "psycopg", None)
    with pytest.raises(BadSettings, match=r"pip install 'breastrig\[postgres\]'"):
        Storage(Location(tmp_path, address))


def test_a_new_data_folder_gets_the_id_of_the_rows_and_one_of_other_rows_is_refused(
    postgres: PostgresServer, storage: Storage, tmp_path: Path
) -> None:
    elsewhere = Storage(Location(tmp_path / "elsewhere", storage.location.database))
    purge_nothing(elsewhere.location)
    assert (tmp_path / "elsewhere" / "installation").read_text() == storage.database.installation_id()
    elsewhere.prepare()
    elsewhere.close()
    other = Storage(Location(tmp_path / "elsewhere", postgres.new_database()))
    with pytest.raises(BadSettings, match="belong to another database"):
        other.prepare()
    other.close()


def purge_nothing(location: Location) -> None:
    storage = Storage(location)
    try:
        with storage.exclusive():
            pass
    finally:
        storage.close()


def test_without_the_servers_programs_the_sentence_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("BREASTRIG_POSTGRES", raising=False)
    monkeypatch.setattr("helpers.postgres_server.PLACES", "/nowhere")
    with pytest.raises(AssertionError, match="apt-get install postgresql"):
        programs()
    assert "BREASTRIG_POSTGRES" in NONE_HERE
