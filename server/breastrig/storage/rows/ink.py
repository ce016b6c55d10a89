"""Rows of ink: the lines found on a scan's skin, one row a scan."""

import json
from typing import Any

from sqlalchemy import delete, insert, select

from breastrig.core.errors import NotFound
from breastrig.storage import schema
from breastrig.storage.storage import Storage


def get_ink(storage: Storage, scan_id: str) -> dict[str, Any] | None:
    """The drawing that was found; None when nobody has looked yet."""
    table = schema.ink
    with storage.database.reading() as connection:
        text = connection.execute(select(table.c.json).where(table.c.scan == scan_id)).scalar_one_or_none()
    return None if text is None else json.loads(text)


def put_ink(storage: Storage, scan_id: str, drawing: dict[str, Any]) -> None:
    """Keeps what was found.  Raises NotFound when the scan is gone."""
    with storage.database.writing() as connection:
        if connection.execute(select(schema.scans.c.id).where(schema.scans.c.id == scan_id)).first() is None:
            raise NotFound("There is no such scan; it may have been deleted.")
        connection.execute(delete(schema.ink).where(schema.ink.c.scan == scan_id))
        connection.execute(insert(schema.ink).values(scan=scan_id, json=json.dumps(drawing, separators=(",", ":"))))
