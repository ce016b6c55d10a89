"""Rows of share links and of their openings.

Of the secret in the link only a hash is stored, and of the credential that a browser gets at an opening only an HMAC
over the share's id: neither can be got back, and what belongs to one share is nothing at another.
"""

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass

from sqlalchemy import ColumnElement, Connection, Select, and_, func, insert, or_, select, true, update

from breastrig.core.errors import Conflict, NotFound
from breastrig.storage import schema
from breastrig.storage.file_journal import clear_entries, record_removal
from breastrig.storage.files import share_place
from breastrig.storage.rows.queries import is_there, newest_first, value_of
from breastrig.storage.storage import Storage


@dataclass(frozen=True)
class ShareRow:
    id: str
    fit: str
    created_at: str
    expires_at: str  # ISO 8601, UTC
    scan: str  # none, plain (the shape alone), full (with its colours)
    passcode_hash: str | None
    snapshot: str | None  # the place of the files that it shows; None once it is over
    snapshot_at: str | None  # when they were made
    notes: bool = False  # whether those of the plan are shown
    revoked_at: str | None = None
    openings: int = 0
    last_opened_at: str | None = None
    wrong_passcodes: int = 0  # since the link was made
    last_wrong_at: str | None = None
    forgiven_passcodes: int = 0  # of them, by the owner

    def is_valid(self, now: str) -> bool:
        """Whether the link has neither expired nor been revoked at a time (as `iso_utc`)."""
        return self.revoked_at is None and now < self.expires_at and self.snapshot is not None

    def is_locked(self, most_wrong: int) -> bool:
        """Whether so many wrong passcodes were given that it opens for nobody until the owner unlocks it."""
        return self.wrong_passcodes - self.forgiven_passcodes >= most_wrong


def add_share(storage: Storage, share: ShareRow, token_sha256: str) -> None:
    """The files of its snapshot are kept from then on.  Raises NotFound when the fit is gone."""
    with storage.database.writing() as connection:
        if not is_there(connection, schema.fits, share.fit):
            raise NotFound("There is no such fit; it may have been deleted.")
        values = {name: value for name, value in asdict(share).items() if name in schema.shares.c}
        connection.execute(insert(schema.shares).values(token_sha256=token_sha256, **values))
        clear_entries(connection, _places([share.snapshot]))


def get_share(storage: Storage, fit_id: str, share_id: str) -> ShareRow:
    """Raises NotFound."""
    found = _one(storage, _query().where(schema.shares.c.fit == fit_id, schema.shares.c.id == share_id))
    if found is None:
        raise NotFound("This fit has no such share.")
    return found


def share_of_token(storage: Storage, token_sha256: str) -> ShareRow | None:
    """The share that a link's secret opens, expired or revoked ones too."""
    return _one(storage, _query().where(schema.shares.c.token_sha256 == token_sha256))


def shares_page(storage: Storage, fit_id: str, limit: int, before: int | None) -> tuple[list[ShareRow], int | None]:
    """Shares of a fit, the newest first, and where the next page goes on (None: there is none)."""
    table = schema.shares
    rows, more = newest_first(storage, _query().where(table.c.fit == fit_id), table.c.position, limit, before)
    return [value_of(ShareRow, row) for row in rows], more


def replace_snapshot(storage: Storage, share: ShareRow, scan_id: str, snapshot: str, now: str) -> None:
    """The link shows that one from now on; the files of the one before are in the journal for removal.

    Raises NotFound when the share is gone, Conflict when it is over.
    """
    table = schema.shares
    with storage.database.writing() as connection:
        row = connection.execute(select(table).where(table.c.id == share.id)).one_or_none()
        if row is None:
            raise NotFound("This share has been deleted.")
        if row.revoked_at is not None or row.expires_at <= now:
            raise Conflict("This link is over; make a new one.")
        connection.execute(update(table).where(table.c.id == share.id).values(snapshot=snapshot, snapshot_at=now))
        clear_entries(connection, _places([snapshot]))
        record_removal(connection, scan_id, _places([row.snapshot]))


def revoke_share(storage: Storage, fit_id: str, share_id: str, now: str) -> list[str]:
    """Closes the link for good; one that is closed or not there is no error.

    Its files are in the journal for removal; the scan they are of.
    """
    table = schema.shares
    with storage.database.writing() as connection:
        chosen = update(table).where(table.c.fit == fit_id, table.c.id == share_id, table.c.revoked_at.is_(None))
        connection.execute(chosen.values(revoked_at=now))
        return _end_snapshots(connection, and_(table.c.fit == fit_id, table.c.id == share_id), now)


def end_snapshots(storage: Storage, now: str) -> list[str]:
    """Of all links that are over: their files are in the journal for removal.  The scans they are of."""
    with storage.database.reading() as connection:
        if not connection.execute(_over(now)).all():
            return []
    with storage.database.writing() as connection:
        return _end_snapshots(connection, true(), now)


def _end_snapshots(connection: Connection, of: ColumnElement[bool], now: str) -> list[str]:
    rows = connection.execute(_over(now).where(of)).all()
    for row in rows:
        record_removal(connection, row.scan, _places([row.snapshot]))
        connection.execute(update(schema.shares).where(schema.shares.c.id == row.id).values(snapshot=None))
    return [row.scan for row in rows]


def _over(now: str) -> Select[tuple[str, str, str]]:
    """Links that are over and still have files."""
    table, fits = schema.shares, schema.fits
    is_over = or_(table.c.revoked_at.is_not(None), table.c.expires_at <= now)
    chosen = select(table.c.id, table.c.snapshot, fits.c.scan).join(fits, fits.c.id == table.c.fit)
    return chosen.where(is_over, table.c.snapshot.is_not(None))


def snapshot_places(connection: Connection, fits: Sequence[str] | None = None) -> list[str]:
    """Where the files of all links are, or of those of some fits."""
    chosen = select(schema.shares.c.snapshot)
    if fits is not None:
        chosen = chosen.where(schema.shares.c.fit.in_(fits))
    return _places(connection.execute(chosen).scalars())


def _places(snapshots: Iterable[str | None]) -> list[str]:
    return [share_place(each) for each in snapshots if each is not None]


def add_opening(storage: Storage, share_id: str, now: str, visit_hmac: str, most_wrong: int) -> bool:
    """Notes the opening with its visit; False when wrong passcodes have locked the link meanwhile.

    Raises NotFound when the share is gone.  Decided with the write lock held, as in `note_wrong_passcode`, so that of
    any number of guesses that are checked at the same time no more than `most_wrong` are answered.
    """
    with storage.database.writing() as connection:
        table = schema.shares
        counts = select(table.c.wrong_passcodes - table.c.forgiven_passcodes).where(table.c.id == share_id)
        wrong = connection.execute(counts).scalar_one_or_none()
        if wrong is None:
            raise NotFound("This share has been deleted.")
        if wrong >= most_wrong:
            return False
        connection.execute(insert(schema.openings).values(share=share_id, opened_at=now, visit_hmac=visit_hmac))
    return True


def note_wrong_passcode(storage: Storage, share_id: str, now: str, most_wrong: int) -> bool:
    """Counts it; False, and nothing counted, when others have locked the link meanwhile or it is gone."""
    table = schema.shares
    wrong = table.c.wrong_passcodes - table.c.forgiven_passcodes
    with storage.database.writing() as connection:
        counted = {"wrong_passcodes": table.c.wrong_passcodes + 1, "last_wrong_at": now}
        chosen = update(table).where(table.c.id == share_id, wrong < most_wrong)
        return connection.execute(chosen.values(counted)).rowcount > 0


def unlock_share(storage: Storage, fit_id: str, share_id: str) -> None:
    """Forgives the wrong passcodes so far; one that is not there is no error."""
    table = schema.shares
    with storage.database.writing() as connection:
        chosen = update(table).where(table.c.fit == fit_id, table.c.id == share_id)
        connection.execute(chosen.values(forgiven_passcodes=table.c.wrong_passcodes))


def share_of_visit(storage: Storage, share_id: str, visit_hmac: str, opened_after: str) -> ShareRow | None:
    """The share, if a visit of it that was started after a time (as `iso_utc`) has not been ended."""
    visit = schema.openings.alias().c  # the query itself counts the openings
    here = select(visit.id).where(
        visit.share == share_id, visit.visit_hmac == visit_hmac, visit.opened_at > opened_after
    )
    return _one(storage, _query().where(schema.shares.c.id == share_id, here.exists()))


def end_visit(storage: Storage, share_id: str, visit_hmac: str) -> bool:
    """Makes the visit's credential worth nothing; whether there was such a visit."""
    table = schema.openings
    with storage.database.writing() as connection:
        chosen = update(table).where(table.c.share == share_id, table.c.visit_hmac == visit_hmac)
        return connection.execute(chosen.values(visit_hmac=None)).rowcount > 0


def openings_of(storage: Storage, share_id: str, limit: int) -> list[str]:
    """When the link was opened, the last time first."""
    table = schema.openings
    with storage.database.reading() as connection:
        query = select(table.c.opened_at).where(table.c.share == share_id).order_by(table.c.id.desc()).limit(limit)
        return list(connection.execute(query).scalars())


def _query() -> Select[tuple[object, ...]]:
    opened = schema.openings.c
    return (
        select(
            schema.shares, func.count(opened.id).label("openings"), func.max(opened.opened_at).label("last_opened_at")
        )
        .outerjoin(schema.openings, opened.share == schema.shares.c.id)
        .group_by(schema.shares.c.position)
    )


def _one(storage: Storage, query: Select[tuple[object, ...]]) -> ShareRow | None:
    with storage.database.reading() as connection:
        row = connection.execute(query).one_or_none()
    return None if row is None else value_of(ShareRow, row)
