"""Rows of proposed landmarks: one a scan, made with one model."""

import json
from typing import Any

from sqlalchemy import delete, insert, select

from breastrig.core.errors import NotFound
from breastrig.storage import schema
from breastrig.storage.storage import Storage


def get_proposals(storage: Storage, scan_id: str, model_sha256: str) -> dict[str, Any] | None:
    """What that model proposed; None when it has not yet."""
    table = schema.proposals
    with storage.database.reading() as connection:
        query = select(table.c.json).where(table.c.scan == scan_id, table.c.model_sha256 == model_sha256)
        text = connection.execute(query).scalar_one_or_none()
    return None if text is None else json.loads(text)


def put_proposals(storage: Storage, scan_id: str, model_sha256: str, landmarks: dict[str, Any]) -> None:
    """Keeps the proposals, in place of an older model's.  Raises NotFound when the scan is gone."""
    values = {"model_sha256": model_sha256, "json": json.dumps(landmarks)}
    with storage.database.writing() as connection:
        if connection.execute(select(schema.scans.c.id).where(schema.scans.c.id == scan_id)).first() is None:
            raise NotFound("There is no such scan; it may have been deleted.")
        connection.execute(delete(schema.proposals).where(schema.proposals.c.scan == scan_id))
        connection.execute(insert(schema.proposals).values(scan=scan_id, **values))
