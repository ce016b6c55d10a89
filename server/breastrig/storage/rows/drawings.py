"""Rows of the surgeon's own drawings: one a scan, a document of the form breastrig/drawing@1."""

import json
from typing import Any

from sqlalchemy import delete, insert, select

from breastrig.core.errors import NotFound
from breastrig.storage import schema
from breastrig.storage.storage import Storage


def get_drawing(storage: Storage, scan_id: str) -> dict[str, Any] | None:
    """None when nothing was drawn on the scan."""
    with storage.database.reading() as connection:
        query = select(schema.drawings.c.json).where(schema.drawings.c.scan == scan_id)
        text = connection.execute(query).scalar_one_or_none()
    return None if text is None else json.loads(text)


def put_drawing(storage: Storage, scan_id: str, drawing: dict[str, Any]) -> None:
    """Replaces the scan's drawing.  Raises NotFound when the scan is gone."""
    table = schema.drawings
    with storage.database.writing() as connection:
        if connection.execute(select(schema.scans.c.id).where(schema.scans.c.id == scan_id)).first() is None:
            raise NotFound("There is no such scan; it may have been deleted.")
        connection.execute(delete(table).where(table.c.scan == scan_id))
        connection.execute(insert(table).values(scan=scan_id, json=json.dumps(drawing, separators=(",", ":"))))
