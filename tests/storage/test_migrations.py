"""Databases of every version become those of this one, and keep their rows."""

import json
import sqlite3
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from helpers.first_version import FIRST_VERSION
from sqlalchemy import inspect

from breastrig.cli.main import main
from breastrig.storage import schema
from breastrig.storage.migrate import alembic_config, known_revisions
from breastrig.storage.rows.events import append, events_after
from breastrig.storage.rows.fits import get_fit, next_queued
from breastrig.storage.rows.patients import get_plan, patient_of_scan, patients_page
from breastrig.storage.rows.scans import Picks, get_landmarks, get_scan
from breastrig.storage.storage import Storage


@pytest.fixture
def old(tmp_path: Path) -> Storage:
    """The storage of a data folder that the first version has left."""
    (tmp_path / "old").mkdir()
    connection = sqlite3.connect(tmp_path / "old" / "breastrig.sqlite3")
    connection.executescript(FIRST_VERSION)
    connection.close()
    return Storage(tmp_path / "old")


def assert_tables_of_this_version(storage: Storage) -> None:
    """What the revisions make is what `schema` says, and Alembic's own check agrees."""
    with storage.database.writing() as connection:
        assert compare_metadata(MigrationContext.configure(connection), schema.metadata) == []
        command.check(alembic_config(connection))


def tables(storage: Storage) -> dict[str, Any]:
    """Everything that the database says of its tables."""
    with storage.database.reading() as connection:
        seen = inspect(connection)
        names = seen.get_table_names()
        lists = (seen.get_columns, seen.get_indexes, seen.get_unique_constraints, seen.get_foreign_keys)
        found = {name: [seen.get_pk_constraint(name), *(sorted(map(str, of(name))) for of in lists)] for name in names}
        return found | {"version": connection.exec_driver_sql("SELECT version_num FROM alembic_version").all()}


def test_an_empty_database_gets_the_tables_of_this_version(storage: Storage) -> None:
    assert_tables_of_this_version(storage)


def test_an_empty_database_gets_the_tables_that_all_revisions_make(storage: Storage, tmp_path: Path) -> None:
    step_by_step = Storage(tmp_path / "by revisions")
    step_by_step.root.mkdir()
    with step_by_step.database.writing() as connection:
        command.upgrade(alembic_config(connection), "head")
    assert tables(step_by_step) == tables(storage)
    step_by_step.close()


def test_an_empty_database_is_filled_without_alembic(tmp_path: Path) -> None:
    program = (
        "import sys; from pathlib import Path; from breastrig.storage.storage import Storage\n"
        f"storage = Storage(Path({str(tmp_path / 'new')!r})); storage.prepare(); storage.close()\n"
        "print('alembic' in sys.modules)"
    )
    said = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True).stdout
    assert said == "False\n"


def test_a_database_of_the_first_version_gets_the_tables_of_this_one_and_keeps_its_rows(old: Storage) -> None:
    old.prepare()
    assert_tables_of_this_version(old)
    assert get_scan(old, "scan-1").facts == {"unit": "mm"}
    assert get_landmarks(old, "scan-1") == Picks({"nipple_L": [1.0, 2.0, 3.0]}, ())
    fit = get_fit(old, "fit-1")
    assert (fit.refine, fit.certain, fit.both, fit.last_event) == (False, (), ("fit-1",), 1)
    assert next_queued(old, set()) == "fit-1"
    assert append(old, "fit-1", {"kind": "failed", "reason": "a test"}) == 2
    assert [event.kind for event in events_after(old, "fit-1", 0)] == ["started", "failed"]
    old.close()


def test_a_drawing_of_an_older_version_becomes_the_plan_of_a_patient(old: Storage) -> None:
    line = {"name": "incision", "closed": False, "color": "#101010", "points": [[1.0, 2.0, 3.0]]}
    with old.database.writing() as connection:
        command.upgrade(alembic_config(connection), "0009")
        connection.exec_driver_sql("INSERT INTO drawings VALUES ('scan-1', ?)", (json.dumps({"shapes": [line]}),))
    old.prepare()
    assert patient_of_scan(old, "scan-1") == "scan-1"
    plan = get_plan(old, "scan-1")
    assert (plan.version, plan.is_whole) == (1, False)
    assert plan.items == (line | {"id": "line-1", "scan": "scan-1", "kind": "line"},)
    old.close()


def test_what_was_done_and_named_before_is_judged_and_sorted_like_what_comes(old: Storage) -> None:
    done = {"kind": "done", "result": {"verdict": {"level": "check", "reasons": ["look"]}}}
    with old.database.writing() as connection:
        command.upgrade(alembic_config(connection), "0010")
        connection.exec_driver_sql("UPDATE patients SET code = 'Ward 12' WHERE id = 'scan-1'")
        connection.exec_driver_sql("INSERT INTO patients (id, code, created_at) VALUES ('other', 'ward 9', '2026')")
        connection.exec_driver_sql(
            "INSERT INTO events (fit, number, kind, json) VALUES ('fit-1', 2, 'done', ?)", (json.dumps(done),)
        )
    old.prepare()
    assert get_fit(old, "fit-1").verdict == "check"
    rows, more = patients_page(old, 10, None, sort="code")
    assert ([row.id for row in rows], more) == (["other", "scan-1"], None)
    old.close()


def test_bringing_up_to_date_again_changes_nothing(old: Storage) -> None:
    old.prepare()
    old.prepare()
    assert_tables_of_this_version(old)
    assert get_scan(old, "scan-1").file_type == "ply"
    old.close()


def test_an_upgrade_that_breaks_leaves_the_database_as_it_was(old: Storage, monkeypatch: pytest.MonkeyPatch) -> None:
    def upgrade_and_break(config: object, revision: str) -> None:
        real(config, revision)
        raise RuntimeError

    real = command.upgrade
    monkeypatch.setattr(command, "upgrade", upgrade_and_break)
    with pytest.raises(RuntimeError):
        old.prepare()
    rows = sqlite3.connect(old.root / "breastrig.sqlite3")
    tables = {row[0] for row in rows.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    assert tables == {"scans", "landmarks", "fits", "events", "sqlite_sequence"}
    rows.close()
    old.close()


def test_a_database_of_a_newer_version_is_refused_and_left_alone(
    storage: Storage, capsys: pytest.CaptureFixture[str]
) -> None:
    with storage.database.writing() as connection:
        connection.exec_driver_sql("UPDATE alembic_version SET version_num = '9999'")
    for command_line in (["serve", "--port", "0"], ["purge", "--all"]):
        assert main([*command_line, "--data", str(storage.root)]) == 2
        said = capsys.readouterr().err
        assert said.startswith("breastrig: A newer version of BreastRig has used this database; ")
        assert said.count("\n") == 1
    with storage.database.reading() as connection:
        assert connection.exec_driver_sql("SELECT version_num FROM alembic_version").scalar_one() == "9999"


def test_the_revisions_form_one_line_as_their_files_are_numbered(storage: Storage) -> None:
    with storage.database.reading() as connection:
        scripts = ScriptDirectory.from_config(alembic_config(connection))
    known = [script.revision for script in scripts.walk_revisions()][::-1]
    assert known == known_revisions() == [f"{number:04}" for number in range(1, len(known) + 1)]


def test_a_database_that_is_up_to_date_is_seen_without_alembic(storage: Storage) -> None:
    program = (
        "import sys; from pathlib import Path; from breastrig.storage.storage import Storage\n"
        "Storage(Path(sys.argv[1])).prepare(); sys.exit('alembic' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", program, str(storage.root)], check=False).returncode == 0
