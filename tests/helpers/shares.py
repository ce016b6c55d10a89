"""Share links whose time is over without waiting for it."""

from datetime import UTC, datetime, timedelta

from breastrig.service.service import Service
from breastrig.storage import schema
from breastrig.storage.storage import iso_utc


def expire(service: Service, share_id: str) -> None:
    """Sets the share's end to a second ago."""
    past = iso_utc(datetime.now(UTC) - timedelta(seconds=1))
    with service.storage.database.writing() as connection:
        connection.execute(schema.shares.update().where(schema.shares.c.id == share_id).values(expires_at=past))
