"""Share links whose time is over without waiting for it."""

from datetime import UTC, datetime, timedelta
from pathlib import Path

from sqlalchemy import select

from breastrig.service.service import Service
from breastrig.storage import schema
from breastrig.storage.storage import iso_utc


def shown_files(service: Service, share_id: str) -> Path:
    """The folder of what the link shows."""
    with service.storage.database.reading() as connection:
        chosen = select(schema.shares.c.snapshot).where(schema.shares.c.id == share_id)
        snapshot = connection.execute(chosen).scalar_one()
    return service.storage.root / "shares" / snapshot


def expire(service: Service, share_id: str) -> None:
    """Sets the share's end to a second ago."""
    past = iso_utc(datetime.now(UTC) - timedelta(seconds=1))
    with service.storage.database.writing() as connection:
        connection.execute(schema.shares.update().where(schema.shares.c.id == share_id).values(expires_at=past))
