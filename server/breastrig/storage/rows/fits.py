"""Rows of fits.  The table is also the queue: the oldest queued row is the next to run."""

import hashlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from sqlalchemy import Connection, bindparam, func, insert, select, update

from breastrig.core.errors import BadInput, Conflict, NotFound
from breastrig.core.picks import Points
from breastrig.storage import schema
from breastrig.storage.file_journal import clear_entries
from breastrig.storage.files import fit_place
from breastrig.storage.rows.queries import check_scan, newest_first, value_of
from breastrig.storage.rows.scans import Cuts, cuts_digest, get_cuts
from breastrig.storage.storage import Storage

STATES = ("queued", "running", "done", "failed", "cancelled")
ENDED = frozenset(STATES[2:])
ONE = select(schema.fits).where(schema.fits.c.id == bindparam("fit_id"))  # asked for with nearly each call


@dataclass(frozen=True, kw_only=True)
class NewFit:
    """A fit as it was asked for, before it has an id and a place in the queue."""

    scan: str
    stance: str = "auto"
    preset: str = "default"
    drawing: str | None = None
    landmarks_mm: Points
    certain: tuple[str, ...] = ()  # of the landmarks, those that are followed whatever all else says
    confidence: dict[str, float] = field(default_factory=dict)  # 0 to 1, of those that were proposed; absent: placed
    cuts: Cuts = ()  # of the scan, by hand
    refine: bool = False
    start_from: str | None = None  # an earlier fit of the same scan
    predicted_from: str | None = None  # of a prediction: the fit of the same scan, in another stance


@dataclass(frozen=True, kw_only=True)
class FitRow(NewFit):
    """What was asked for, and how far it has come; `stance` is the decided one once the fit has started."""

    id: str
    asked_stance: str  # auto, standing, supine, prone
    created_at: str
    state: str  # queued, running, done, failed, cancelled
    attempt: int  # how often a worker has started it; events of an earlier attempt are refused
    last_event: int
    iterations: int
    numbers: dict[str, Any] | None  # the last iterated event without its nodes
    reason: str | None
    verdict: str | None  # good, uncalibrated, check or unusable; None before the end

    @property
    def ended(self) -> bool:
        return self.state in ENDED


@dataclass(frozen=True)
class Once:
    """A request that may be sent again without being executed again."""

    key_sha256: str
    request_sha256: str

    @classmethod
    def of(cls, key: str, request: str) -> "Once":
        """From the Idempotency-Key and the request's text."""
        key_sha256, request_sha256 = (hashlib.sha256(text.encode()).hexdigest() for text in (key, request))
        return cls(key_sha256, request_sha256)


def add_fit(storage: Storage, created_at: str, fit_id: str, new_fit: NewFit, once: Once | None = None) -> str:
    """Puts a fit at the end of the queue.

    Returns its id, or that of the fit which the same request, or the same prediction, has made before.  Raises
    NotFound when the scan is gone, BadInput when the key came with another request.
    """
    with storage.database.writing() as connection:
        same = _same_prediction(connection, new_fit)
        if same is not None:
            return same
        if once is not None:
            made = _made_before(connection, once)
            if made is not None:
                return made
        check_scan(connection, new_fit.scan)
        place = connection.execute(select(func.coalesce(func.max(schema.fits.c.place), 0) + 1)).scalar_one()
        values = {
            **asdict(new_fit),
            "asked_stance": new_fit.stance,
            "id": fit_id,
            "place": place,
            "created_at": created_at,
            "state": "queued",
            "last_event": 0,
            "iterations": 0,
        }
        connection.execute(insert(schema.fits).values(values))
        clear_entries(connection, [fit_place(fit_id)])
        if once is not None:
            connection.execute(insert(schema.asked_once).values(fit=fit_id, **asdict(once)))
    return fit_id


def _made_before(connection: Connection, once: Once) -> str | None:
    table = schema.asked_once
    row = connection.execute(select(table).where(table.c.key_sha256 == once.key_sha256)).one_or_none()
    if row is None:
        return None
    if row.request_sha256 != once.request_sha256:
        raise BadInput("This Idempotency-Key came with another request before; use a new key for a new fit.")
    return str(row.fit)


def _same_prediction(connection: Connection, new_fit: NewFit) -> str | None:
    """One that waits, runs or is done; those that failed or were cancelled are made again."""
    if new_fit.predicted_from is None:
        return None
    asked = {"predicted_from": new_fit.predicted_from, "asked_stance": new_fit.stance, "simulate": False}
    found = select(schema.fits.c.id).filter_by(**asked).where(schema.fits.c.state.in_(STATES[:3]))
    return connection.execute(found).scalars().first()


def get_fit(storage: Storage, fit_id: str) -> FitRow:
    """Raises NotFound."""
    with storage.database.reading() as connection:
        row = connection.execute(ONE, {"fit_id": fit_id}).one_or_none()
    if row is None:
        raise NotFound("There is no such fit; it may have been deleted.")
    return value_of(FitRow, row)


def shown_cuts(storage: Storage, fit: FitRow) -> Cuts:
    """What is cut by hand, now, out of what the fit shows; of a prediction nothing, for its scan was cut before.

    Raises Conflict when that scan is cut otherwise by now.
    """
    cuts = get_cuts(storage, fit.scan)
    if fit.predicted_from is None:
        return cuts
    if cuts_digest(cuts) != cuts_digest(fit.cuts):
        raise Conflict("The scan was cut after this was predicted from it; fit it again, and predict from that fit.")
    return ()


def claim_fit(storage: Storage, fit_id: str) -> FitRow | None:
    """Begins a new attempt at a fit that waits or runs; None when there is nothing to do.

    Whoever was at it before can store nothing more.
    """
    table = schema.fits
    with storage.database.writing() as connection:
        claimed = connection.execute(
            update(table)
            .where(table.c.id == fit_id, table.c.state.in_(("queued", "running")))
            .values(state="running", attempt=table.c.attempt + 1)
        )
        if claimed.rowcount == 0:
            return None
        return value_of(FitRow, connection.execute(select(table).where(table.c.id == fit_id)).one())


def put_back(storage: Storage) -> int:
    """Puts the fits that run back into the queue, at their old places, because nobody carries them out any more.

    How many they were.  A worker that is still at one can store nothing more, as the fit no longer runs.
    """
    table = schema.fits
    with storage.database.writing() as connection:
        return connection.execute(update(table).where(table.c.state == "running").values(state="queued")).rowcount


def next_queued(storage: Storage, besides: set[str]) -> str | None:
    """The oldest queued fit that is not among `besides`."""
    table = schema.fits
    with storage.database.reading() as connection:
        query = (
            select(table.c.id)
            .where(table.c.state == "queued", table.c.id.not_in(besides))
            .order_by(table.c.place)
            .limit(1)
        )
        return connection.execute(query).scalar_one_or_none()


def queue_positions(storage: Storage, fit_ids: Sequence[str]) -> dict[str, int]:
    """{fit: 1 for the next to run, 2 for the one after it}; those that do not wait are not in it."""
    table = schema.fits
    position = func.row_number().over(order_by=table.c.place)
    waiting = select(table.c.id, position.label("position")).where(table.c.state == "queued").subquery()
    with storage.database.reading() as connection:
        rows = connection.execute(select(waiting).where(waiting.c.id.in_(fit_ids)))
        return {row.id: int(row.position) for row in rows}


def still_queued(storage: Storage, fit_ids: set[str]) -> set[str]:
    """Those of the fits that wait."""
    table = schema.fits
    with storage.database.reading() as connection:
        query = select(table.c.id).where(table.c.state == "queued", table.c.id.in_(fit_ids))
        return set(connection.execute(query).scalars())


def count_by_state(storage: Storage) -> dict[str, int]:
    """How many fits are in each state that any fit is in."""
    table = schema.fits
    with storage.database.reading() as connection:
        rows = connection.execute(select(table.c.state, func.count()).group_by(table.c.state))
        return {row[0]: int(row[1]) for row in rows}


def made_before(storage: Storage, once: Once) -> str | None:
    """The fit that the same request has made; BadInput when the key came with another request."""
    with storage.database.reading() as connection:
        return _made_before(connection, once)


def fits_in_state(storage: Storage, state: str) -> list[str]:
    with storage.database.reading() as connection:
        return list(connection.execute(select(schema.fits.c.id).where(schema.fits.c.state == state)).scalars())


def fits_of_scan(storage: Storage, scan_id: str) -> list[str]:
    with storage.database.reading() as connection:
        return list(connection.execute(select(schema.fits.c.id).where(schema.fits.c.scan == scan_id)).scalars())


def fits_page(
    storage: Storage, limit: int, before: int | None = None, scan_id: str | None = None
) -> tuple[list[FitRow], int | None]:
    """Fits, or those of a scan, the newest first, and where the next page goes on (None: there is none)."""
    table = schema.fits
    query = select(table) if scan_id is None else select(table).where(table.c.scan == scan_id)
    rows, more = newest_first(storage, query, table.c.place, limit, before)
    return [value_of(FitRow, row) for row in rows], more


def newest_done(storage: Storage, scan_id: str) -> FitRow | None:
    """The fit of the scan that was asked for last among those that are done; no prediction."""
    table = schema.fits
    chosen = select(table).where(table.c.scan == scan_id, table.c.state == "done", table.c.predicted_from.is_(None))
    with storage.database.reading() as connection:
        row = connection.execute(chosen.order_by(table.c.place.desc()).limit(1)).one_or_none()
    return None if row is None else value_of(FitRow, row)


def newest_fits(storage: Storage, scan_ids: Sequence[str]) -> dict[str, FitRow]:
    """{scan: its fit that was asked for last, no prediction}; scans without a fit are not in it."""
    table = schema.fits
    fitted = select(func.max(table.c.place)).where(table.c.scan.in_(scan_ids), table.c.predicted_from.is_(None))
    last = fitted.group_by(table.c.scan)
    with storage.database.reading() as connection:
        rows = connection.execute(select(table).where(table.c.place.in_(last)))
        return {row.scan: value_of(FitRow, row) for row in rows}


def fit_ids(storage: Storage) -> set[str]:
    with storage.database.reading() as connection:
        return set(connection.execute(select(schema.fits.c.id)).scalars())
