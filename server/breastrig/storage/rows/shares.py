"""Rows of share links and of their openings.

Of the secret in the link only a hash is stored, and of the credential that a browser gets at an opening only an HMAC
over the share's id: neither can be got back, and what belongs to one share is nothing at another.
"""

from dataclasses import dataclass

from sqlalchemy import Row, Select, func, insert, select, update

from breastrig.core.errors import NotFound
from breastrig.storage import schema
from breastrig.storage.rows.paging import newest_first
from breastrig.storage.storage import Storage


@dataclass(frozen=True)
class ShareRow:
    id: str
    fit: str
    created_at: str
    expires_at: str  # ISO 8601, UTC
    scan: str  # none, plain (the shape alone), full (with its colours)
    passcode_hash: str | None
    revoked_at: str | None = None
    openings: int = 0
    last_opened_at: str | None = None
    wrong_passcodes: int = 0  # since the link was made
    last_wrong_at: str | None = None
    forgiven_passcodes: int = 0  # of them, by the owner

    def is_valid(self, now: str) -> bool:
        """Whether the link has neither expired nor been revoked at a time (as `iso_utc`)."""
        return self.revoked_at is None and now < self.expires_at

    def is_locked(self, most_wrong: int) -> bool:
        """Whether so many wrong passcodes were given that it opens for nobody until the owner unlocks it."""
        return self.wrong_passcodes - self.forgiven_passcodes >= most_wrong


def add_share(storage: Storage, share: ShareRow, token_sha256: str) -> None:
    """Raises NotFound when the fit is gone."""
    with storage.database.writing() as connection:
        if connection.execute(select(schema.fits.c.id).where(schema.fits.c.id == share.fit)).first() is None:
            raise NotFound("There is no such fit; it may have been deleted.")
        values = {
            "id": share.id,
            "fit": share.fit,
            "token_sha256": token_sha256,
            "created_at": share.created_at,
            "expires_at": share.expires_at,
            "scan": share.scan,
            "passcode_hash": share.passcode_hash,
        }
        connection.execute(insert(schema.shares).values(values))


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
    return [_share_row(row) for row in rows], more


def revoke_share(storage: Storage, fit_id: str, share_id: str, now: str) -> None:
    """Closes the link for good.  One that is closed or not there is no error."""
    table = schema.shares
    with storage.database.writing() as connection:
        chosen = update(table).where(table.c.fit == fit_id, table.c.id == share_id, table.c.revoked_at.is_(None))
        connection.execute(chosen.values(revoked_at=now))


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
    """The share, if a visit of it that was begun after a time (as `iso_utc`) has not been ended."""
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
        select(schema.shares, func.count(opened.id).label("openings"), func.max(opened.opened_at).label("last"))
        .outerjoin(schema.openings, opened.share == schema.shares.c.id)
        .group_by(schema.shares.c.position)
    )


def _one(storage: Storage, query: Select[tuple[object, ...]]) -> ShareRow | None:
    with storage.database.reading() as connection:
        row = connection.execute(query).one_or_none()
    return None if row is None else _share_row(row)


def _share_row(row: Row[tuple[object, ...]]) -> ShareRow:
    return ShareRow(
        id=row.id,
        fit=row.fit,
        created_at=row.created_at,
        expires_at=row.expires_at,
        scan=row.scan,
        passcode_hash=row.passcode_hash,
        revoked_at=row.revoked_at,
        openings=row.openings,
        last_opened_at=row.last,
        wrong_passcodes=row.wrong_passcodes,
        last_wrong_at=row.last_wrong_at,
        forgiven_passcodes=row.forgiven_passcodes,
    )
