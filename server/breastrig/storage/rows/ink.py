"""Rows of ink: the lines found on a scan's skin, one row a scan, and which of them a person has dropped."""

import json
from collections.abc import Mapping
from typing import Any

from sqlalchemy import insert, select, update

from breastrig.core.errors import BadDrawing, Conflict, NotFound
from breastrig.storage import schema
from breastrig.storage.storage import Storage

GONE = "There is no such scan; it may have been deleted."
NOT_YET = "The ink of this scan has not been looked for yet; ask for it first."


def get_ink(storage: Storage, scan_id: str) -> dict[str, Any] | None:
    """The drawing that was found, shapes that were dropped marked; None when nobody has looked yet."""
    table = schema.ink
    with storage.database.reading() as connection:
        row = connection.execute(select(table.c.json, table.c.dropped).where(table.c.scan == scan_id)).first()
    return None if row is None else _drawing(row.json, set(json.loads(row.dropped)))


def put_ink(storage: Storage, scan_id: str, drawing: dict[str, Any]) -> None:
    """Keeps what was found.  Raises NotFound when the scan is gone."""
    table, text = schema.ink, json.dumps(drawing, separators=(",", ":"))
    with storage.database.writing() as connection:
        if connection.execute(select(schema.scans.c.id).where(schema.scans.c.id == scan_id)).first() is None:
            raise NotFound(GONE)
        if connection.execute(update(table).where(table.c.scan == scan_id).values(json=text)).rowcount == 0:
            connection.execute(insert(table).values(scan=scan_id, json=text))


def drop_ink(storage: Storage, scan_id: str, dropped: Mapping[str, bool]) -> dict[str, Any]:
    """Keeps of the named shapes whether they are dropped, others stay as they are; answers as `get_ink`.

    Raises NotFound when the scan is gone, Conflict before its ink was found, BadDrawing for a name that it has not.
    """
    table = schema.ink
    with storage.database.writing() as connection:
        if connection.execute(select(schema.scans.c.id).where(schema.scans.c.id == scan_id)).first() is None:
            raise NotFound(GONE)
        row = connection.execute(select(table.c.json, table.c.dropped).where(table.c.scan == scan_id)).first()
        if row is None:
            raise Conflict(NOT_YET)
        names = {shape["name"] for shape in json.loads(row.json)["shapes"]}
        strange = next((name for name in dropped if name not in names), None)
        if strange is not None:
            raise BadDrawing(f'No line called "{strange}" was found on this scan; name one of those that were.')
        now = (set(json.loads(row.dropped)) | {name for name, is_so in dropped.items() if is_so}) - {
            name for name, is_so in dropped.items() if not is_so
        }
        connection.execute(update(table).where(table.c.scan == scan_id).values(dropped=json.dumps(sorted(now))))
    return _drawing(row.json, now)


def _drawing(text: str, dropped: set[str]) -> dict[str, Any]:
    drawing: dict[str, Any] = json.loads(text)
    shapes = [shape | {"dropped": True} if shape["name"] in dropped else shape for shape in drawing["shapes"]]
    return drawing | {"shapes": shapes}
