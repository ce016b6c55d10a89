import threading
from pathlib import Path

import pytest
from helpers.rows import add_waiting_fit
from sqlalchemy import insert, select
from sqlalchemy.exc import IntegrityError

from breastrig.storage import schema
from breastrig.storage.fits import get_fit, next_queued
from breastrig.storage.storage import Storage

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


def test_a_data_folder_of_an_older_version_gets_the_columns_it_lacks(storage: Storage, scan_id: str) -> None:
    add_waiting_fit(storage, scan_id, "fit-1")
    with storage.database.writing() as connection:
        for column in ("refine", "partner", "leads"):
            connection.exec_driver_sql(f"ALTER TABLE fits DROP COLUMN {column}")
        connection.exec_driver_sql("DROP TABLE asked_once")
    again = Storage(storage.root)
    again.prepare()
    assert get_fit(again, "fit-1").refine is False
    assert get_fit(again, "fit-1").both == ("fit-1",)
    assert next_queued(again, set()) == "fit-1"
    again.close()


def test_every_column_that_came_later_can_be_added(storage: Storage) -> None:
    first_version = {
        "scans": {"id", "created_at", "file_type", "sha256", "facts"},
        "landmarks": {"scan", "points_mm"},
        "events": {"position", "fit", "number", "kind", "json"},
        "fits": {"id", "place", "scan", "created_at", "state", "stance", "preset", "drawing"}
        | {"landmarks_mm", "last_event", "iterations", "numbers", "reason"},
    }
    for name, columns in first_version.items():
        for column in schema.metadata.tables[name].columns:
            assert column.name in columns or column.nullable or column.server_default is not None


def test_only_the_owner_can_look_into_the_data_folder(storage: Storage, tmp_path: Path) -> None:
    assert (tmp_path / "data").stat().st_mode & 0o077 == 0
