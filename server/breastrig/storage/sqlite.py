"""SQLite, the default: one file of the data folder.

Write-ahead log (readers never wait for the writer), a long busy timeout, foreign keys on, deleted rows overwritten.
A writing transaction takes the write lock at its start (`BEGIN IMMEDIATE`), because a transaction that reads first
and writes later can be refused by SQLite without any waiting.

Nothing in a process that has the database open may open its files in another way, not even to read them: on
closing such a file POSIX drops the process's locks, and other processes then remove the log under its feet.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, create_engine, event
from sqlalchemy.exc import SQLAlchemyError

from breastrig.storage.database import BUSY_TIMEOUT_S, Database


class SqliteDatabase(Database):
    """The file may not be there yet."""

    def __init__(self, file: Path) -> None:
        super().__init__(
            create_engine(
                f"sqlite:///{file}",
                connect_args={"timeout": BUSY_TIMEOUT_S},
                hide_parameters=True,  # an error that is logged shows no row
            )
        )
        event.listen(self.engine, "connect", _set_up_connection)
        event.listen(self.engine, "begin", _begin)

    @contextmanager
    def writing(self) -> Iterator[Connection]:
        with self.engine.connect().execution_options(breastrig_writes=True) as connection, connection.begin():
            yield connection

    @contextmanager
    def exclusive(self) -> Iterator[None]:
        """The lock of the data folder is this database's as well."""
        yield

    def can_write(self, wait_s: float) -> bool:
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


def _set_up_connection(connection: Any, _record: Any) -> None:
    connection.isolation_level = None  # the driver opens no transaction of its own; _begin does
    cursor = connection.cursor()
    for pragma in ("journal_mode=WAL", "synchronous=NORMAL", "foreign_keys=ON", "secure_delete=ON"):
        cursor.execute(f"PRAGMA {pragma}")
    cursor.close()


def _begin(connection: Connection) -> None:
    writes = connection.get_execution_options().get("breastrig_writes", False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")
