import subprocess
import sys
import threading
from pathlib import Path

import pytest
from sqlalchemy import Connection, event, insert, select
from sqlalchemy.exc import IntegrityError

from breastrig.storage import schema
from breastrig.storage.rows.patients import patient_of_scan, put_items_of_scan, put_plan, rename_patient
from breastrig.storage.storage import Storage

NORMAL, FULL = 1, 2  # of PRAGMA synchronous
LANDMARKS_OF_NOBODY = {"scan": "nobody", "points_mm": "{}"}


def test_the_log_is_written_ahead_and_foreign_keys_hold(storage: Storage) -> None:
    with storage.database.reading() as connection:
        pragmas = {
            name: connection.exec_driver_sql(f"PRAGMA {name}").scalar_one()
            for name in ("journal_mode", "foreign_keys", "busy_timeout", "secure_delete")
        }
    assert pragmas == {"journal_mode": "wal", "foreign_keys": 1, "busy_timeout": 30000, "secure_delete": 1}


def test_rows_that_point_nowhere_are_refused(storage: Storage) -> None:
    with pytest.raises(IntegrityError), storage.database.writing() as connection:
        connection.execute(insert(schema.landmarks).values(LANDMARKS_OF_NOBODY))


def test_an_error_undoes_the_whole_transaction(storage: Storage, scan_id: str) -> None:
    def write_and_fail() -> None:
        with storage.database.writing() as connection:
            connection.execute(insert(schema.landmarks).values(scan=scan_id, points_mm="{}"))
            raise RuntimeError

    with pytest.raises(RuntimeError):
        write_and_fail()
    with storage.database.reading() as connection:
        assert connection.execute(select(schema.landmarks)).all() == []


def test_a_reader_does_not_wait_for_a_writer(storage: Storage, scan_id: str) -> None:
    with storage.database.writing() as writer:
        writer.execute(insert(schema.landmarks).values(scan=scan_id, points_mm="{}"))
        with storage.database.reading() as reader:
            assert reader.execute(select(schema.landmarks)).all() == []


def test_writers_wait_for_each_other(storage: Storage, scan_id: str) -> None:
    steps: list[str] = []
    inside = threading.Event()

    def second() -> None:
        inside.wait()
        with storage.database.writing():
            steps.append("second")

    thread = threading.Thread(target=second)
    thread.start()
    with storage.database.writing():
        inside.set()
        thread.join(timeout=0.1)
        steps.append("first")
    thread.join()
    assert steps == ["first", "second"]


def test_preparing_twice_changes_nothing(storage: Storage, scan_id: str) -> None:
    again = Storage(storage.root)
    again.prepare()
    with again.database.reading() as connection:
        assert connection.execute(select(schema.scans.c.id)).scalars().all() == [scan_id]
    again.close()


def test_only_the_owner_can_look_into_the_data_folder(storage: Storage, tmp_path: Path) -> None:
    assert (tmp_path / "data").stat().st_mode & 0o077 == 0


def test_a_look_for_damage_takes_no_lock_away(storage: Storage, scan_id: str) -> None:
    """Else another process that closes the database would remove the log, and with it what was written last."""
    look = "import sqlite3, sys; rows = sqlite3.connect(sys.argv[1]); rows.execute('SELECT * FROM scans'); rows.close()"
    file = storage.root / "breastrig.sqlite3"
    assert storage.database.is_sound(1.0)
    subprocess.run([sys.executable, "-c", look, str(file)], check=True)
    assert file.with_name("breastrig.sqlite3-wal").stat().st_size > 0


def test_a_new_database_can_be_read_by_its_owner_alone(tmp_path: Path) -> None:
    (tmp_path / "open").mkdir(mode=0o755)
    storage = Storage(tmp_path / "open")
    storage.prepare()
    assert [path.stat().st_mode & 0o077 for path in storage.root.glob("breastrig.sqlite3*")] == [0, 0, 0]
    storage.close()


def test_a_plan_is_on_the_disk_before_it_is_answered(storage: Storage, scan_id: str) -> None:
    """What SQLite has not synchronised is lost when the power fails."""
    levels: list[int] = []

    @event.listens_for(storage.database.engine, "commit")
    def note(connection: Connection) -> None:
        levels.append(connection.exec_driver_sql("PRAGMA synchronous").scalar_one())

    patient = patient_of_scan(storage, scan_id)
    item = {"id": "a", "kind": "note", "scan": scan_id, "text": "x"}
    writes = (
        (NORMAL, lambda: rename_patient(storage, patient, "P-1")),
        (FULL, lambda: put_plan(storage, patient, [item], 0)),
        (FULL, lambda: put_items_of_scan(storage, scan_id, "note", [item])),
        (NORMAL, lambda: rename_patient(storage, patient, "P-2")),  # on the same connection
    )
    for level, write in writes:
        write()
        assert levels[-1] == level
