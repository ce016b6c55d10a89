"""One SQLAlchemy engine, with two kinds of transaction.

SQLite by default: write-ahead log (readers never wait for the writer), a long busy timeout, foreign keys on,
deleted rows overwritten.  A writing transaction takes the write lock at its start (`BEGIN IMMEDIATE`), because a
transaction that reads first and writes later can be refused by SQLite without any waiting.  Reading
transactions take no lock, so that any number of open streams does not slow the workers down.

Nothing in a process that has the database open may open its files in another way, not even to read them: on
closing such a file POSIX drops the process's locks, and other processes then remove the log under its feet.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Engine, create_engine, event
from sqlalchemy.exc import SQLAlchemyError

from breastrig.storage.migrate import to_this_version

BUSY_TIMEOUT_S = 30.0  # far above the longest writing transaction (a few ms), so that only a hung disk shows


class Database:
    """Opens connections; safe to share between threads, to be opened again in every process."""

    def __init__(self, file: Path) -> None:
        self.engine: Engine = create_engine(
            f"sqlite:///{file}",
            connect_args={"timeout": BUSY_TIMEOUT_S},
            hide_parameters=True,  # an error that is logged shows no row
        )
        event.listen(self.engine, "connect", _set_up_connection)
        event.listen(self.engine, "begin", _begin)

    def bring_up_to_date(self) -> None:
        """Makes the tables, or turns those of an older version into this one's.

        Raises BadSettings when they are of a newer version.
        """
        with self.writing() as connection:
            to_this_version(connection)

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """A transaction that sees one state of the database and changes nothing."""
        with self.engine.connect() as connection:
            yield connection

    @contextmanager
    def writing(self) -> Iterator[Connection]:
        """A transaction that holds the write lock from its start; commits at the end, or undoes all on an error."""
        with self.engine.connect().execution_options(breastrig_writes=True) as connection, connection.begin():
            yield connection

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

    def forget_deleted(self) -> None:
        """Empties the write-ahead log, so that no deleted row is left in any file."""
        with self.engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
            connection.exec_driver_sql("PRAGMA wal_checkpoint(TRUNCATE)")

    def close(self) -> None:
        self.engine.dispose()


def _set_up_connection(connection: Any, _record: Any) -> None:
    connection.isolation_level = None  # the driver opens no transaction of its own; _begin does
    cursor = connection.cursor()
    for pragma in ("journal_mode=WAL", "synchronous=NORMAL", "foreign_keys=ON", "secure_delete=ON"):
        cursor.execute(f"PRAGMA {pragma}")
    cursor.close()


def _begin(connection: Connection) -> None:
    writes = connection.get_execution_options().get("breastrig_writes", False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")
