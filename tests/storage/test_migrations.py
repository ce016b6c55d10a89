"""The revisions turn the tables of the first one into those of `schema`; databases of other versions are refused."""

import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import inspect

from breastrig.cli.main import main
from breastrig.core.errors import BadSettings
from breastrig.core.version import __version__
from breastrig.storage import schema
from breastrig.storage.data_folder import SQLITE_FILE
from breastrig.storage.revisions import alembic_config, known_revisions
from breastrig.storage.rows.fits import get_fit, next_queued, queue_positions
from breastrig.storage.storage import Storage


def assert_tables_of_this_version(storage: Storage) -> None:
    """What is there is what `schema` says, and Alembic's own check agrees."""
    with storage.database.writing() as connection:
        assert compare_metadata(MigrationContext.configure(connection), schema.metadata) == []
        command.check(alembic_config(connection))


def test_an_empty_database_gets_the_tables_of_this_version(storage: Storage) -> None:
    assert_tables_of_this_version(storage)


def test_the_tables_of_the_first_revision_are_brought_to_this_version(storage: Storage) -> None:
    storage.close()
    file = storage.root / SQLITE_FILE
    file.unlink()
    with closing(sqlite3.connect(file)) as rows:
        rows.executescript(Path(__file__).with_name("tables_0001.sql").read_text())
    storage.prepare()
    assert_tables_of_this_version(storage)


def test_two_stances_that_were_fitted_together_stay_as_two_fits(storage: Storage) -> None:
    storage.close()
    file = storage.root / SQLITE_FILE
    file.unlink()
    with closing(sqlite3.connect(file)) as rows:
        rows.executescript(Path(__file__).with_name("tables_0001.sql").read_text())
        known = ("id", "created_at", "file_type", "sha256", "facts")
        fit = (
            *("id", "place", "scan", "created_at", "state", "stance", "preset", "landmarks_mm"),
            *("last_event", "iterations", "partner", "leads"),
        )
        for number, (scan, own, other, state) in enumerate(
            [("s", "a", "b", "done"), ("t", "b", "a", "done"), ("s", "c", "d", "queued"), ("t", "d", "c", "queued")]
        ):
            rows.execute(f"INSERT OR IGNORE INTO scans {known} VALUES (?, 'then', 'ply', 'ab', '{{}}')", (scan,))
            values = (own, number, scan, "then", state, "auto", "default", "{}", 0, 0, other, own < other)
            rows.execute(f"INSERT INTO fits {fit} VALUES ({', '.join('?' * len(fit))})", values)
        rows.commit()
    storage.prepare()
    assert [get_fit(storage, name).state for name in "abcd"] == ["done", "done", "queued", "queued"]
    assert queue_positions(storage, ["c", "d"]) == {"c": 1, "d": 2}
    assert next_queued(storage, {"c"}) == "d"


def test_a_database_of_another_version_is_refused_and_left_alone(
    storage: Storage, capsys: pytest.CaptureFixture[str]
) -> None:
    with storage.database.writing() as connection:
        connection.exec_driver_sql("UPDATE alembic_version SET version_num = '9999'")
    for command_line in (["serve", "--port", "0"], ["purge", "--all"]):
        assert main([*command_line, "--data", str(storage.root)]) == 2
        said = capsys.readouterr().err
        assert said.startswith(
            "breastrig: A newer BreastRig has used this database (its tables have revision 9999), and "
        )
        assert (
            f"this is BreastRig {__version__}, which knows revision {known_revisions()[-1]}; install the newer" in said
        )
        assert said.count("\n") == 1
    with storage.database.reading() as connection:
        assert connection.exec_driver_sql("SELECT version_num FROM alembic_version").scalar_one() == "9999"


def test_tables_without_a_revision_are_refused(storage: Storage) -> None:
    with storage.database.writing() as connection:
        connection.exec_driver_sql("DROP TABLE alembic_version")
    with pytest.raises(
        BadSettings, match=r"An older BreastRig, of before 0\.2\.0, has used this database, .* --data\.$"
    ) as told:
        storage.prepare()
    assert f"this is BreastRig {__version__}" in str(told.value)


def test_a_creation_that_breaks_leaves_the_database_empty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stamp_and_break(config: object, revision: str) -> None:
        real(config, revision)
        raise RuntimeError

    real = command.stamp
    monkeypatch.setattr(command, "stamp", stamp_and_break)
    storage = Storage(tmp_path / "new")
    with pytest.raises(RuntimeError):
        storage.prepare()
    with storage.database.reading() as rows:
        assert inspect(rows).get_table_names() == []
    storage.close()


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
