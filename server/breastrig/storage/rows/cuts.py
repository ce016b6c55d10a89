"""Rows of cuts: what a person has cut out of a scan, one row a scan, none where nothing is cut."""

import hashlib
import json
from collections.abc import Sequence
from typing import Any

from sqlalchemy import delete, insert, select

from breastrig.core.errors import NotFound
from breastrig.storage import schema
from breastrig.storage.storage import Storage

Cuts = tuple[dict[str, Any], ...]  # {to_picture, lasso}, see scan/hand_cuts.py


def get_cuts(storage: Storage, scan_id: str) -> Cuts:
    """The first that was made first; none where nothing was cut."""
    table = schema.cuts
    with storage.database.reading() as connection:
        text = connection.execute(select(table.c.json).where(table.c.scan == scan_id)).scalar_one_or_none()
    return () if text is None else tuple(json.loads(text))


def put_cuts(storage: Storage, scan_id: str, cuts: Cuts, seen: str | None = None) -> bool:
    """Replaces the scan's cuts; where `seen`, a digest, is given, only those, else it answers False.

    Raises NotFound when the scan is gone.
    """
    with storage.database.writing() as connection:
        if connection.execute(select(schema.scans.c.id).where(schema.scans.c.id == scan_id)).first() is None:
            raise NotFound("There is no such scan; it may have been deleted.")
        if seen is not None:
            text = connection.execute(select(schema.cuts.c.json).where(schema.cuts.c.scan == scan_id)).scalar()
            if seen != cuts_digest(() if text is None else json.loads(text)):
                return False
        connection.execute(delete(schema.cuts).where(schema.cuts.c.scan == scan_id))
        if cuts:
            connection.execute(insert(schema.cuts).values(scan=scan_id, json=cuts_text(cuts)))
    return True


def cuts_text(cuts: Sequence[dict[str, Any]]) -> str:
    """As they are stored."""
    return json.dumps(cuts, separators=(",", ":"), sort_keys=True)


def cuts_digest(cuts: Sequence[dict[str, Any]]) -> str:
    """The same for the same cuts; empty where nothing was cut."""
    return hashlib.sha256(cuts_text(cuts).encode()).hexdigest()[:16] if cuts else ""
