"""Rows of scans, of their landmarks, and of what a person has cut out of them."""

import hashlib
import json
from collections.abc import Collection, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from sqlalchemy import Connection, delete, insert, select, tuple_

from breastrig.core.picks import Picks
from breastrig.storage import schema
from breastrig.storage.file_journal import clear_entries
from breastrig.storage.files import scan_place
from breastrig.storage.rows.patients import put_scan
from breastrig.storage.rows.queries import check_scan, no_such_scan, value_of
from breastrig.storage.storage import Storage

Cuts = tuple[dict[str, Any], ...]  # {to_picture, lasso}, see scan/hand_cuts.py


@dataclass(frozen=True)
class ScanRow:
    id: str
    created_at: str
    file_type: str
    sha256: str
    facts: dict[str, Any]  # what reading found: unit, counts, bounds, frame, stance, notes


def add_scan(storage: Storage, row: ScanRow, patient: str | None = None, again: bool = False) -> None:
    """Its files have been kept; it is of that patient, or of a new one.

    Raises NotFound when she is gone, and NeedsYes where she has that file already and nobody said `again`.
    """
    with storage.database.writing() as connection:
        connection.execute(insert(schema.scans).values(asdict(row)))
        put_scan(connection, row.id, patient, row.created_at, again)
        clear_entries(connection, [scan_place(row.id)])


def get_scan(storage: Storage, scan_id: str) -> ScanRow:
    """Raises NotFound."""
    with storage.database.reading() as connection:
        row = connection.execute(select(schema.scans).where(schema.scans.c.id == scan_id)).one_or_none()
    if row is None:
        raise no_such_scan()
    return value_of(ScanRow, row)


def are_kept(storage: Storage, ids: Collection[str]) -> bool:
    """Whether none of the scans has been deleted."""
    with storage.database.reading() as connection:
        found = connection.execute(select(schema.scans.c.id).where(schema.scans.c.id.in_(ids))).scalars()
        return set(found) == set(ids)


def get_scans(storage: Storage, ids: Sequence[str]) -> list[ScanRow]:
    """Those of the scans that are there, the first that came first."""
    table = schema.scans
    with storage.database.reading() as connection:
        rows = connection.execute(select(table).where(table.c.id.in_(ids)).order_by(table.c.created_at, table.c.id))
        return [value_of(ScanRow, row) for row in rows]


def scans_page(
    storage: Storage, limit: int, last: tuple[str, str] | None = None
) -> tuple[list[ScanRow], tuple[str, str] | None]:
    """Scans after the `last` one's time and id, the newest first, and where the next page goes on (None: nowhere)."""
    table = schema.scans
    query = select(table).order_by(table.c.created_at.desc(), table.c.id.desc()).limit(limit + 1)
    if last is not None:
        query = query.where(tuple_(table.c.created_at, table.c.id) < last)
    with storage.database.reading() as connection:
        rows = [value_of(ScanRow, row) for row in connection.execute(query)]
    return rows[:limit], (rows[limit - 1].created_at, rows[limit - 1].id) if len(rows) > limit else None


def scan_ids(storage: Storage) -> set[str]:
    with storage.database.reading() as connection:
        return set(connection.execute(select(schema.scans.c.id)).scalars())


def scans_before(storage: Storage, moment: str) -> list[str]:
    """The scans that were created before a time (as `iso_utc`), the oldest first."""
    table = schema.scans
    with storage.database.reading() as connection:
        query = select(table.c.id).where(table.c.created_at < moment).order_by(table.c.created_at)
        return list(connection.execute(query).scalars())


def get_landmarks(storage: Storage, scan_id: str) -> Picks:
    """Empty when none were stored."""
    with storage.database.reading() as connection:
        return _picks(connection, scan_id)


def _picks(connection: Connection, scan_id: str) -> Picks:
    row = connection.execute(select(schema.landmarks).where(schema.landmarks.c.scan == scan_id)).one_or_none()
    return Picks({}) if row is None else value_of(Picks, row)


def put_landmarks(storage: Storage, scan_id: str, picks: Picks, seen: str | None = None) -> bool:
    """Replaces the scan's landmarks; where `seen`, a digest, is given, only those, else it answers False.

    Raises NotFound when the scan is gone.
    """
    table = schema.landmarks
    with storage.database.writing() as connection:
        check_scan(connection, scan_id)
        if seen is not None and seen != picks_digest(_picks(connection, scan_id)):
            return False
        connection.execute(delete(table).where(table.c.scan == scan_id))
        connection.execute(insert(table).values(scan=scan_id, **asdict(picks)))
    return True


def picks_digest(picks: Picks) -> str:
    """The same for the same landmarks, in whatever order they were placed; empty where there are none."""
    if not picks.points_mm:
        return ""
    points = {name: [float(value) for value in point] for name, point in picks.points_mm.items()}
    text = json.dumps([points, sorted(picks.certain), picks.confidence], separators=(",", ":"), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def get_cuts(storage: Storage, scan_id: str) -> Cuts:
    """The first that was made first; none where nothing was cut."""
    with storage.database.reading() as connection:
        return _cuts(connection, scan_id)


def _cuts(connection: Connection, scan_id: str) -> Cuts:
    query = select(schema.cuts.c.json).where(schema.cuts.c.scan == scan_id)
    return connection.execute(query).scalar_one_or_none() or ()


def put_cuts(storage: Storage, scan_id: str, cuts: Cuts, seen: str | None = None) -> bool:
    """The same of cuts."""
    table = schema.cuts
    with storage.database.writing() as connection:
        check_scan(connection, scan_id)
        if seen is not None and seen != cuts_digest(_cuts(connection, scan_id)):
            return False
        connection.execute(delete(table).where(table.c.scan == scan_id))
        if cuts:
            connection.execute(insert(table).values(scan=scan_id, json=cuts))
    return True


def cuts_digest(cuts: Sequence[dict[str, Any]]) -> str:
    """The same for the same cuts; empty where nothing was cut."""
    text = json.dumps(cuts, separators=(",", ":"), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16] if cuts else ""
