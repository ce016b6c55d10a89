"""Rows of scans that are nearly too old: since when their deletion has been announced."""

from collections.abc import Iterable
from dataclasses import dataclass

from sqlalchemy import delete, insert, or_, select

from breastrig.storage import schema
from breastrig.storage.rows.queries import is_there, value_of
from breastrig.storage.storage import Storage

TABLE = schema.expiring_scans


@dataclass(frozen=True)
class AgedScan:
    """Times as `iso_utc`."""

    id: str
    created_at: str
    announced_at: str | None


def aged_scans(storage: Storage, created_until: str) -> list[AgedScan]:
    """Scans of up to that time, and all whose deletion has been announced; the oldest first."""
    scans = schema.scans.c
    query = (
        select(scans.id, scans.created_at, TABLE.c.announced_at)
        .outerjoin(TABLE, TABLE.c.scan == scans.id)
        .where(or_(scans.created_at <= created_until, TABLE.c.announced_at.is_not(None)))
        .order_by(scans.created_at)
    )
    with storage.database.reading() as connection:
        return [value_of(AgedScan, row) for row in connection.execute(query)]


def announce(storage: Storage, scan_ids: Iterable[str], now: str) -> None:
    """Notes that the scans' deletion is announced now, whatever was noted before.  One that is gone is left out."""
    with storage.database.writing() as connection:
        for scan_id in scan_ids:
            connection.execute(delete(TABLE).where(TABLE.c.scan == scan_id))
            if is_there(connection, schema.scans, scan_id):
                connection.execute(insert(TABLE).values(scan=scan_id, announced_at=now))


def withdraw(storage: Storage, scan_ids: Iterable[str]) -> None:
    """The scans are not as old as it seemed."""
    with storage.database.writing() as connection:
        for scan_id in scan_ids:
            connection.execute(delete(TABLE).where(TABLE.c.scan == scan_id))
