"""Share links: what they show is in the case, what opens them in the index alone.

Of the secret in the link only a hash is stored, and of the credential that a browser gets at an opening only an HMAC
over the share's id: neither can be got back, and what belongs to one share is nothing at another.
"""

from contextlib import suppress
from dataclasses import dataclass

from breastrig.cases import links
from breastrig.cases.documents import LinkDocument
from breastrig.core.errors import NotFound
from breastrig.index import questions
from breastrig.index.questions import LinkSecret
from breastrig.storage.files import share_place
from breastrig.storage.storage import Storage

NO_SHARE = "This fit has no such share."


@dataclass(frozen=True)
class StoredShare:
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


def add_share(storage: Storage, share: StoredShare, token_sha256: str) -> StoredShare:
    """Keeps the link with the snapshot that was made under its place.  Raises NotFound when the fit is gone."""
    case, scan_id = storage.case_of_fit(share.fit)
    document = LinkDocument(
        created_at=share.created_at,
        expires_at=share.expires_at,
        scan=share.scan,  # type: ignore[arg-type]  # which the document checks
        notes=share.notes,
    )
    assert share.snapshot is not None
    links.add_link(case, scan_id, share.fit, document, storage.files.made(share_place(share.snapshot)), share.id)
    storage.index.refresh(case.id)
    with storage.index.writing() as rows:  # a link without it is over
        questions.put_secret(rows, LinkSecret(share.id, token_sha256, share.passcode_hash))
    return get_share(storage, share.fit, share.id)


def get_share(storage: Storage, fit_id: str, share_id: str) -> StoredShare:
    """The share's row. Raises NotFound."""
    try:
        case, scan_id = storage.case_of_fit(fit_id)
        document = links.get_link(case, scan_id, fit_id, share_id)
    except NotFound as error:
        raise NotFound(NO_SHARE) from error
    return _row(storage, fit_id, share_id, document)


def share_of_token(storage: Storage, token_sha256: str) -> StoredShare | None:
    """The share that a link's secret opens, expired or revoked ones too."""
    secret = storage.index.asked(questions.secret_of_token, token_sha256)
    return None if secret is None else _share(storage, secret.link)


def shares_page(storage: Storage, fit_id: str, limit: int, before: int | None) -> tuple[list[StoredShare], int | None]:
    """Shares of a fit, the newest first, and where the next page goes on (None: there is none)."""
    case, scan_id = storage.case_of_fit(fit_id)
    found = list(enumerate(links.links_of_fit(case, scan_id, fit_id).items(), start=1))[::-1]
    wanted = [one for one in found if before is None or one[0] < before]
    rows = [_row(storage, fit_id, share_id, document) for _, (share_id, document) in wanted[:limit]]
    return rows, wanted[limit - 1][0] if len(wanted) > limit else None


def replace_snapshot(storage: Storage, share: StoredShare, snapshot: str) -> None:
    """The link shows that one from now on, made under its place; the one before is gone.

    Raises NotFound when the share is gone, Conflict when it is over.
    """
    case, scan_id = storage.case_of_fit(share.fit)
    links.refresh_link(case, scan_id, share.fit, share.id, storage.files.made(share_place(snapshot)))


def revoke_share(storage: Storage, fit_id: str, share_id: str) -> None:
    """Closes the link for good and removes what it shows; one that is closed or not there is no error.

    Raises OSError for what cannot be removed yet.
    """
    with suppress(NotFound):
        case, scan_id = storage.case_of_fit(fit_id)
        links.end_link(case, scan_id, fit_id, share_id)
        storage.index.refresh(case.id)


def end_snapshots(storage: Storage, now: str) -> None:
    """Removes the contents of links that are over."""
    for fit_id, share_id in storage.index.asked(questions.links_over, now):
        revoke_share(storage, fit_id, share_id)


def add_opening(storage: Storage, share_id: str, now: str, visit_hmac: str, most_wrong: int) -> bool:
    """Notes the opening with its visit; False when wrong passcodes have locked the link meanwhile.

    Raises NotFound when the share is gone.  Decided with the write lock held, as in `note_wrong_passcode`, so that of
    any number of guesses that are checked at the same time no more than `most_wrong` are answered.
    """
    with storage.index.writing() as rows:
        wrong = questions.wrong_passcodes(rows, share_id)
        if wrong is None:
            raise NotFound("This share has been deleted.")
        if wrong >= most_wrong:
            return False
        questions.note_opening(rows, share_id, now, visit_hmac)
    return True


def note_wrong_passcode(storage: Storage, share_id: str, now: str, most_wrong: int) -> bool:
    """Counts it; False, and nothing counted, when others have locked the link meanwhile or it is gone."""
    with storage.index.writing() as rows:
        wrong = questions.wrong_passcodes(rows, share_id)
        if wrong is None or wrong >= most_wrong:
            return False
        questions.count_wrong(rows, share_id, now)
    return True


def unlock_share(storage: Storage, fit_id: str, share_id: str) -> None:
    """Forgives the wrong passcodes so far; one that is not there is no error."""
    with suppress(NotFound):
        get_share(storage, fit_id, share_id)
        with storage.index.writing() as rows:
            questions.forgive(rows, share_id)


def share_of_visit(storage: Storage, share_id: str, visit_hmac: str, opened_after: str) -> StoredShare | None:
    """The share, if a visit of it that was started after a time (as `iso_utc`) has not been ended."""
    if not storage.index.asked(questions.has_visit, share_id, visit_hmac, opened_after):
        return None
    return _share(storage, share_id)


def end_visit(storage: Storage, share_id: str, visit_hmac: str) -> bool:
    """Voids the visit's credential; returns whether there was such a visit."""
    with storage.index.writing() as rows:
        return questions.end_visit(rows, share_id, visit_hmac)


def openings_of(storage: Storage, share_id: str, limit: int) -> list[str]:
    """The times at which the link was opened, newest first."""
    return storage.index.asked(questions.openings_of, share_id)[::-1][:limit]


def _share(storage: Storage, share_id: str) -> StoredShare | None:
    where = storage.index.asked(questions.fit_of_link, share_id)
    try:
        return None if where is None else get_share(storage, where[2], share_id)
    except NotFound:
        return None


def _row(storage: Storage, fit_id: str, share_id: str, document: LinkDocument) -> StoredShare:
    """The share's row; a link without its secret, which was lost with the index, shows nothing."""
    secret = storage.index.asked(questions.secret_of_link, share_id)
    opened = storage.index.asked(questions.openings_of, share_id)
    return StoredShare(
        id=share_id,
        fit=fit_id,
        created_at=document.created_at,
        expires_at=document.expires_at,
        scan=document.scan,
        passcode_hash=None if secret is None else secret.passcode_hash,
        snapshot=f"{share_id}.{document.shown}" if document.shown and secret is not None else None,
        snapshot_at=document.shown_at,
        notes=document.notes,
        revoked_at=document.revoked_at,
        openings=len(opened),
        last_opened_at=opened[-1] if opened else None,
        wrong_passcodes=0 if secret is None else secret.wrong,
        last_wrong_at=None if secret is None else secret.wrong_at,
        forgiven_passcodes=0 if secret is None else secret.forgiven,
    )
