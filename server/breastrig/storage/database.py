"""One SQLAlchemy engine, with two kinds of transaction: what SQLite and PostgreSQL have in common.

A writing transaction takes one lock for the whole database at its start, so there is one writer at a time.  That
costs nothing, as a transaction takes a few milliseconds, and it makes two things plain: what a transaction has read
stays true until it ends, and `events.position` grows in the order in which events become visible.  Whoever has
read the events up to a position has therefore missed none, and the Notifier of the streams relies on that.

Reading transactions take no lock, so that any number of open streams does not slow the workers down.

A new database is made from `schema`, an older one brought up to date by Alembic's revisions, all in one transaction
(alembic.sqlalchemy.org, cookbook: "Building an Up to Date Database from Scratch").  One that is up to date is seen
without importing Alembic, which takes a third of a second.
"""

import logging
import sys
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from importlib.resources import files
from typing import Any, ClassVar

from sqlalchemy import Connection, Engine, inspect, text

from breastrig.core.errors import BadSettings
from breastrig.core.version import __version__
from breastrig.storage.schema import metadata

FIRST_WITH_REVISION = "0.2.0"  # older ones made tables that do not say of which revision they are
BUSY_TIMEOUT_S = 30.0  # far above the longest writing transaction (a few ms), so that only a hung disk shows

log = logging.getLogger(__name__)


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


def to_this_version(connection: Connection) -> None:
    """Makes the tables, or runs the missing revisions; BadSettings for the tables of another version."""
    found, known = _revision(connection), known_revisions()
    if found == known[-1]:
        return
    if found not in known and (found is not None or inspect(connection).has_table("scans")):
        raise BadSettings(_of_another_version(found, known[-1]))
    from alembic import command

    if found is None:
        metadata.create_all(connection)
        command.stamp(alembic_config(connection), "head")
    else:
        command.upgrade(alembic_config(connection), "head")
    log.info("the tables were brought from revision %s to %s", found or "none", known[-1])


def _of_another_version(found: str | None, newest: str) -> str:
    here = f"this is BreastRig {__version__}"
    if found is None:
        return (
            f"An older BreastRig, of before {FIRST_WITH_REVISION}, has used this database, and {here}, which takes "
            f"over those of {FIRST_WITH_REVISION} and later; start the older one to save what is in it, or choose "
            "another place with --data."
        )
    return (
        f"A newer BreastRig has used this database (its tables have revision {found}), and {here}, which knows "
        f"revision {newest}; install the newer one again, or choose another place with --data."
    )


def known_revisions() -> list[str]:
    """The revisions that this version brings, in order: the numbers in their files' names."""
    names = (file.name for file in (files("breastrig.storage") / "migrations" / "versions").iterdir())
    return sorted(name[1:5] for name in names if name.startswith("r") and name.endswith(".py"))


def alembic_config(connection: Connection) -> Any:
    """Alembic's settings, without a file."""
    from alembic.config import Config

    config = Config(stdout=sys.stdout)  # by default it is that of the moment of import
    folder = str(files("breastrig.storage") / "migrations")
    config.set_main_option("script_location", folder.replace("%", "%%"))
    config.attributes["connection"] = connection
    return config


def _revision(connection: Connection) -> str | None:
    """Of the tables that are there; None without any."""
    if not inspect(connection).has_table("alembic_version"):
        return None
    return connection.execute(text("SELECT version_num FROM alembic_version")).scalar_one_or_none()
