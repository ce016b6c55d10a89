"""Rows of sessions that were left: their cookies are signed and would be good until they are too old."""

from sqlalchemy import delete, insert, select

from breastrig.storage import schema
from breastrig.storage.storage import Storage


def add_ended_session(storage: Storage, id_sha256: str, now: str, forget_before: str) -> None:
    """Notes the end; forgets those that ended before a time (as `iso_utc`).  Ending twice is no error."""
    table = schema.ended_sessions
    with storage.database.writing() as connection:
        connection.execute(delete(table).where((table.c.ended_at < forget_before) | (table.c.id_sha256 == id_sha256)))
        connection.execute(insert(table).values(id_sha256=id_sha256, ended_at=now))


def has_ended(storage: Storage, id_sha256: str) -> bool:
    with storage.database.reading() as connection:
        query = select(schema.ended_sessions.c.id_sha256).where(schema.ended_sessions.c.id_sha256 == id_sha256)
        return connection.execute(query).first() is not None
