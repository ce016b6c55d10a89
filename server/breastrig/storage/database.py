"""The database: one SQLite file of the data folder, seen through one SQLAlchemy engine with two kinds of transaction.

A writing transaction takes one lock for the whole database at its start, so there is one writer at a time.  That
costs nothing, as a transaction takes a few milliseconds, and it makes two things plain: what a transaction has read
stays true until it ends, and `events.position` grows in the order in which events become visible.  Whoever has
read the events up to a position has therefore missed none, and the Notifier of the streams relies on that.

Reading transactions take no lock, so that any number of open streams does not slow the workers down.

Write-ahead log (readers never wait for the writer), a long busy timeout, foreign keys on, deleted rows overwritten.
A writing transaction takes the write lock at its start (`BEGIN IMMEDIATE`), because a transaction that reads first
and writes later can be refused by SQLite without any waiting.

Nothing in a process that has the database open may open its files in another way, not even to read them: on
closing such a file POSIX drops the process's locks, and other processes then remove the log under its feet.
"""

import sqlite3
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, create_engine, event, inspect
from sqlalchemy.exc import SQLAlchemyError

from breastrig.core.errors import BadSettings
from breastrig.storage.revisions import to_this_version

BUSY_TIMEOUT_S = 30.0  # far above the longest writing transaction (a few ms), so that only a hung disk shows
START_CHECK_S = 5.0  # a gigabyte of rows that the system has in memory takes as long
CHECK_EVERY = 10_000  # of SQLite's instructions, about a millisecond
DAMAGED = ("SQLITE_CORRUPT", "SQLITE_NOTADB")  # how the names of these errors begin
NO_ROOM = ("SQLITE_FULL", "SQLITE_IOERR", "SQLITE_CANTOPEN")  # the disk is full, or a file beside it cannot be made


class Database:
    """Opens connections; safe to share between threads, to be opened again in every process.

    The file may not be there yet.
    """

    def __init__(self, file: Path) -> None:
        self._file = file
        self.engine = create_engine(
            f"sqlite:///{file}",
            connect_args={"timeout": BUSY_TIMEOUT_S},
            hide_parameters=True,  # an error that is logged shows no row
        )
        event.listen(self.engine, "connect", _set_up_connection)
        event.listen(self.engine, "begin", _begin)

    def bring_up_to_date(self) -> None:
        """Makes the tables, or turns those of an older version into this one's.

        Raises BadSettings when they are of a newer version, or the file is damaged or no database.
        """
        if self._file.is_file() and self._file.stat().st_size:
            if not self._check(START_CHECK_S, ours=False):
                raise BadSettings(
                    f"The database {self._file} is damaged; put a copy of the data folder in its place, or choose "
                    "another with --data."
                )
        else:
            self._file.touch(mode=0o600)  # SQLite would let others read it
        with self.writing() as connection:
            to_this_version(connection)

    def installation_id(self) -> str | None:
        """None in a database that is new, or of a version without."""
        with self.reading() as connection:
            if not inspect(connection).has_table("installation"):
                return None
            return connection.exec_driver_sql("SELECT id FROM installation").scalar_one_or_none()

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """A transaction that sees one state of the database and changes nothing."""
        with self.engine.connect() as connection:
            yield connection

    @contextmanager
    def writing(self, durable: bool = False) -> Iterator[Connection]:
        """A transaction that holds the write lock from its start; commits at the end, or undoes all on an error.

        What a `durable` one has written is on the disk when it ends, so that it outlives a power failure.
        """
        with self.engine.connect().execution_options(breastrig_writes=True) as connection:
            driver: Any = connection.connection.driver_connection
            if durable:
                driver.execute("PRAGMA synchronous = FULL")
            try:
                with connection.begin():
                    yield connection
            finally:
                if durable:
                    driver.execute("PRAGMA synchronous = NORMAL")

    def can_write(self, wait_s: float) -> bool:
        """Whether a transaction can be committed, waiting so long for others."""
        try:
            with self.engine.connect().execution_options(breastrig_writes=True) as connection:
                driver: Any = connection.connection.driver_connection
                driver.execute(f"PRAGMA busy_timeout = {round(1e3 * wait_s)}")
                try:
                    with connection.begin():
                        connection.exec_driver_sql("PRAGMA user_version = 1")  # a number that nobody reads
                finally:
                    driver.execute(f"PRAGMA busy_timeout = {round(1e3 * BUSY_TIMEOUT_S)}")
        except SQLAlchemyError:
            return False
        return True

    def is_sound(self, limit_s: float) -> bool:
        """Whether rows can be read; looks for damage no longer than that."""
        try:
            return self._check(limit_s, ours=True)
        except sqlite3.Error:
            return False

    def forget_deleted(self) -> bool:
        """Empties the write-ahead log, so that no deleted row is left in any file; False: to be done later."""
        with self.engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
            busy, *_ = connection.exec_driver_sql("PRAGMA wal_checkpoint(TRUNCATE)").one()
        return not busy

    def is_disk_full(self, error: Exception) -> bool:
        """Whether it was met because the disk of the data folder is full."""
        return _name(error).startswith(NO_ROOM)

    def close(self) -> None:
        self.engine.dispose()

    def _check(self, limit_s: float, ours: bool) -> bool:
        """Whether the file is sound as far as can be seen in that time; `ours`: and holds our tables.

        With a connection of its own, as the others remember pages that they have read.  Raises sqlite3.Error.
        """
        deadline = time.monotonic() + limit_s
        address = f"{self._file.absolute().as_uri()}?mode=rw"
        try:
            with closing(sqlite3.connect(f"{address}&immutable=1", uri=True)) as rows:
                rows.execute("PRAGMA schema_version").fetchone()  # of the file itself, whatever the log holds
            with closing(sqlite3.connect(address, uri=True, timeout=BUSY_TIMEOUT_S)) as rows:
                if ours and rows.execute("SELECT id FROM installation").fetchone() is None:
                    return False
                rows.set_progress_handler(lambda: time.monotonic() > deadline, CHECK_EVERY)
                return bool(rows.execute("PRAGMA quick_check(1)").fetchone() == ("ok",))
        except sqlite3.DatabaseError as error:
            name = _name(error)
            if name == "SQLITE_INTERRUPT" or name.startswith("SQLITE_BUSY"):
                return True  # nothing was found so far
            if is_damage(error):
                return False
            raise


def is_damage(error: Exception) -> bool:
    """Whether it was met because the database's file is damaged."""
    return _name(error).startswith(DAMAGED)


def _name(error: Exception) -> str:
    """SQLite's name for an error, also for one that SQLAlchemy has wrapped; empty for others."""
    return str(getattr(getattr(error, "orig", error), "sqlite_errorname", ""))


def _set_up_connection(connection: Any, _record: Any) -> None:
    connection.isolation_level = None  # the driver opens no transaction of its own; _begin does
    cursor = connection.cursor()
    for pragma in ("journal_mode=WAL", "synchronous=NORMAL", "foreign_keys=ON", "secure_delete=ON"):
        cursor.execute(f"PRAGMA {pragma}")
    cursor.close()


def _begin(connection: Connection) -> None:
    writes = connection.get_execution_options().get("breastrig_writes", False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")
