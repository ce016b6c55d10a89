"""Rows of what was found on a scan, one a scan: landmarks that a model proposed, and lines of ink on the skin."""

from collections.abc import Mapping
from typing import Any

from sqlalchemy import delete, insert, select, update

from breastrig.core.errors import BadDrawing, Conflict
from breastrig.storage import schema
from breastrig.storage.rows.queries import check_scan
from breastrig.storage.storage import Storage

NOT_YET = "The ink of this scan has not been looked for yet; ask for it first."


def get_proposals(storage: Storage, scan_id: str, model_sha256: str) -> dict[str, Any] | None:
    """What that model proposed; None when it has not yet."""
    table = schema.proposals
    with storage.database.reading() as connection:
        query = select(table.c.json).where(table.c.scan == scan_id, table.c.model_sha256 == model_sha256)
        return connection.execute(query).scalar_one_or_none()


def put_proposals(storage: Storage, scan_id: str, model_sha256: str, landmarks: dict[str, Any]) -> None:
    """Keeps the proposals, in place of an older model's.  Raises NotFound when the scan is gone."""
    table = schema.proposals
    with storage.database.writing() as connection:
        check_scan(connection, scan_id)
        connection.execute(delete(table).where(table.c.scan == scan_id))
        connection.execute(insert(table).values(scan=scan_id, model_sha256=model_sha256, json=landmarks))


def get_ink(storage: Storage, scan_id: str) -> dict[str, Any] | None:
    """The drawing that was found, shapes that were dropped marked; None when nobody has looked yet."""
    with storage.database.reading() as connection:
        row = connection.execute(select(schema.ink).where(schema.ink.c.scan == scan_id)).first()
    return None if row is None else _drawing(row.json, row.dropped)


def put_ink(storage: Storage, scan_id: str, drawing: dict[str, Any]) -> None:
    """Keeps what was found.  Raises NotFound when the scan is gone."""
    table = schema.ink
    with storage.database.writing() as connection:
        check_scan(connection, scan_id)
        if connection.execute(update(table).where(table.c.scan == scan_id).values(json=drawing)).rowcount == 0:
            connection.execute(insert(table).values(scan=scan_id, json=drawing))


def drop_ink(storage: Storage, scan_id: str, dropped: Mapping[str, bool]) -> dict[str, Any]:
    """Keeps of the named shapes whether they are dropped, others stay as they are; answers as `get_ink`.

    Raises NotFound when the scan is gone, Conflict before its ink was found, BadDrawing for a name that it has not.
    """
    table = schema.ink
    with storage.database.writing() as connection:
        check_scan(connection, scan_id)
        row = connection.execute(select(table).where(table.c.scan == scan_id)).first()
        if row is None:
            raise Conflict(NOT_YET)
        names = {shape["name"] for shape in row.json["shapes"]}
        strange = next((name for name in dropped if name not in names), None)
        if strange is not None:
            raise BadDrawing(f'No line called "{strange}" was found on this scan; name one of those that were.')
        now = {name for name in names if dropped.get(name, name in row.dropped)}
        connection.execute(update(table).where(table.c.scan == scan_id).values(dropped=sorted(now)))
    return _drawing(row.json, now)


def _drawing(drawing: dict[str, Any], dropped: set[str]) -> dict[str, Any]:
    shapes = [shape | {"dropped": True} if shape["name"] in dropped else shape for shape in drawing["shapes"]]
    return drawing | {"shapes": shapes}
