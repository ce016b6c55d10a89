"""One SQLAlchemy engine, with two kinds of transaction: what SQLite and PostgreSQL have in common.

A writing transaction takes one lock for the whole database at its start, so there is one writer at a time.  That
costs nothing, as a transaction takes a few milliseconds, and it makes two things plain: what a transaction has read
stays true until it ends, and `events.position` grows in the order in which events become visible.  Whoever has
read the events up to a position has therefore missed none, and the Notifier of the streams relies on that.

Reading transactions take no lock, so that any number of open streams does not slow the workers down.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any, ClassVar

from sqlalchemy import Connection, Engine, inspect

from breastrig.storage.migrate import to_this_version

BUSY_TIMEOUT_S = 30.0  # far above the longest writing transaction (a few ms), so that only a hung disk shows


class Database(ABC):
    """Opens connections; safe to share between threads, to be opened again in every process."""

    reading_options: ClassVar[dict[str, Any]] = {}  # of SQLAlchemy's connections

    def __init__(self, engine: Engine) -> None:
        self.engine = engine

    def bring_up_to_date(self) -> None:
        """Makes the tables, or turns those of an older version into this one's.

        Raises BadSettings when they are of a newer version.
        """
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
        with self.engine.connect().execution_options(**self.reading_options) as connection:
            yield connection

    @abstractmethod
    def writing(self, durable: bool = False) -> AbstractContextManager[Connection]:
        """A transaction that holds the write lock from its start; commits at the end, or undoes all on an error.

        What a `durable` one has written is on the disk when it ends, so that it outlives a power failure.
        """

    @abstractmethod
    def exclusive(self) -> AbstractContextManager[None]:
        """Holds the database for this server.  Raises BadSettings when another holds it, or it cannot be reached."""

    @abstractmethod
    def can_write(self, wait_s: float) -> bool:
        """Whether a transaction can be committed, waiting so long for others."""

    @abstractmethod
    def is_sound(self, limit_s: float) -> bool:
        """Whether rows can be read; looks for damage no longer than that."""

    @abstractmethod
    def forget_deleted(self) -> bool:
        """Gives up what deleted rows still take, as far as the database can; False when it has to be done later."""

    def is_disk_full(self, error: Exception) -> bool:
        """Whether it was met because the disk of the data folder is full."""
        return False

    def close(self) -> None:
        self.engine.dispose()
