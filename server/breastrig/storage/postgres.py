"""PostgreSQL, for installations of many machines: the rows of one installation fill one database.

The locks are advisory ones, which belong to the database: one that each writing transaction takes at its start, one
that the server holds as long as it runs, and one for each fit that is being executed.  PostgreSQL releases
them when the connection that took them ends, however it ends.

Readers work on one snapshot.  Writers must not: theirs would be older than the lock that they have waited for.
"""

import hashlib
import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, ClassVar

from sqlalchemy import Connection, create_engine, event, make_url, text
from sqlalchemy.exc import ArgumentError, DataError, OperationalError, SQLAlchemyError
from sqlalchemy.pool import NullPool

from breastrig.core.errors import BadInput, BadSettings
from breastrig.storage.database import BUSY_TIMEOUT_S, Database
from breastrig.storage.schema import metadata

CONNECT_TIMEOUT_S = 10  # a server on another continent answers within one
# The locks of a machine that vanished without a word are free after a minute.
KEEPALIVE = "-c tcp_keepalives_idle=30 -c tcp_keepalives_interval=10 -c tcp_keepalives_count=3"
WRITER = 0x42524947_00000001  # any numbers that nobody else takes in this database
SERVER = 0x42524947_00000002


log = logging.getLogger(__name__)


class PostgresDatabase(Database):
    """Raises BadSettings when the URL is none or psycopg is not installed."""

    reading_options: ClassVar[dict[str, Any]] = {"isolation_level": "REPEATABLE READ", "postgresql_readonly": True}

    def __init__(self, url: str) -> None:
        try:
            address = make_url(url).set(drivername="postgresql+psycopg")
            settings = f"-c lock_timeout={round(1e3 * BUSY_TIMEOUT_S)} {KEEPALIVE}"
            connect = {"connect_timeout": CONNECT_TIMEOUT_S, "options": settings, "application_name": "breastrig"}
            shared: dict[str, Any] = {"connect_args": connect, "hide_parameters": True}
            super().__init__(create_engine(address, pool_pre_ping=True, **shared))  # it may have been restarted
            self._lone = create_engine(address, poolclass=NullPool, isolation_level="AUTOCOMMIT", **shared)
        except ArgumentError as error:
            raise BadSettings("The database's URL cannot be read; write postgresql://USER@HOST/NAME.") from error
        except ImportError as error:
            raise BadSettings("PostgreSQL needs psycopg: pip install 'breastrig[postgres]'.") from error
        event.listen(self.engine, "handle_error", _refuse_bad_values)

    @contextmanager
    def writing(self, durable: bool = False) -> Iterator[Connection]:
        """All are durable, unless the server has been set up otherwise."""
        with self.engine.begin() as connection:
            connection.execute(text("SELECT pg_advisory_xact_lock(:lock)"), {"lock": WRITER})
            yield connection

    @contextmanager
    def exclusive(self) -> Iterator[None]:
        try:
            connection = self._lone.connect()
        except OperationalError as error:
            said = str(error.orig).strip().splitlines()[0].rstrip(".")
            raise BadSettings(f"The database cannot be reached ({said}); check that it runs, and its URL.") from error
        with connection:
            if not connection.execute(text("SELECT pg_try_advisory_lock(:lock)"), {"lock": SERVER}).scalar_one():
                raise BadSettings("Another BreastRig server uses this database; stop it or name another.")
            yield

    def can_write(self, wait_s: float) -> bool:
        try:
            with self.engine.begin() as connection:
                connection.exec_driver_sql(f"SET LOCAL lock_timeout = {round(1e3 * wait_s)}")
                connection.execute(text("SELECT pg_advisory_xact_lock(:lock)"), {"lock": WRITER})
                connection.exec_driver_sql("SELECT pg_current_xact_id()")  # a read-only server gives none
        except SQLAlchemyError:
            return False
        return True

    def is_sound(self, limit_s: float) -> bool:
        """PostgreSQL watches over its own files."""
        try:
            return self.installation_id() is not None
        except SQLAlchemyError:
            return False

    def forget_deleted(self) -> bool:
        """Gives the space of deleted rows free; their bytes stay in the server's files until others overwrite them."""
        with self._lone.connect() as connection:
            for table in metadata.sorted_tables:
                connection.exec_driver_sql(f"VACUUM (SKIP_LOCKED) {table.name}")
        return True

    @contextmanager
    def held(self, fit_id: str) -> Iterator[None]:
        """By an advisory lock, as the process may be on another machine.

        Does not wait for ever: who has it may be a machine that was cut off, and its events are refused.
        """
        with self._lone.connect() as connection:
            try:
                connection.execute(text("SELECT pg_advisory_lock(:lock)"), {"lock": _number(fit_id)})
            except OperationalError:
                log.warning("the process that executes fit %s does not end; another one executes it now", fit_id)
            yield

    def wait_until_free(self, fit_id: str, timeout_s: float) -> bool:
        deadline = time.monotonic() + timeout_s
        with self._lone.connect() as connection:
            while not connection.execute(
                text("SELECT pg_try_advisory_lock(:lock)"), {"lock": _number(fit_id)}
            ).scalar_one():
                if time.monotonic() > deadline:
                    return False
                time.sleep(0.01)
        return True

    def close(self) -> None:
        self._lone.dispose()
        super().close()


def _number(fit_id: str) -> int:
    """The fit's lock: 63 bits of a hash, so that two fits, or one and the locks above, do not meet."""
    return int.from_bytes(hashlib.sha256(fit_id.encode()).digest()[:8]) >> 1


def _refuse_bad_values(context: Any) -> None:
    """SQLite stores and compares any value; PostgreSQL refuses some, such as a NUL in an id."""
    if isinstance(context.sqlalchemy_exception, DataError):
        raise BadInput("This holds a character or number that cannot be stored; leave it out.")
