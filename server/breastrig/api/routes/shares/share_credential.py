"""The credentials of a share link's visitors: first the secret of the link, then the credential of a visit.

The secret is 192 random bits in the link's fragment, which browsers do not send; the page posts it once. It is answered
with a cookie of 256 random bits for this visit. The cookie belongs to one share in three ways: its name and its path
hold the share's id, so that a browser with several links open sends to each its own; and the stored value is an HMAC
over that id, so that it is void at another share. It holds nothing of the link: a copy of it is worthless once the
visit was closed, is too old, or the link has ended, all of which is checked at every call.

The cookie ends with the browser. A second one, sent only to `/api/shared/open`, lists the visits of a browser by their
stored values, which open nothing: so a link that is opened again leaves no earlier visit behind, and the oldest visit
ends before there are too many.

Whoever gives a link's passcode gets in, whatever others have guessed: each address that guesses wrong waits longer and
longer, others do not wait. Beyond a number of wrong passcodes in all the link takes none, until its owner, who sees
that number, unlocks it. So no more than that number can ever be tried, however many addresses there are.
"""

import hashlib
import hmac
import re
import secrets
import threading
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from flask import Response, request
from werkzeug.security import check_password_hash

from breastrig.api.app_context import app_context
from breastrig.api.errors import refuse
from breastrig.api.share_limits import COOKIES, VISIT_S, WRONG_PASSCODES
from breastrig.api.trusted_proxy import client_of
from breastrig.storage.documents.shares import (
    StoredShare,
    add_opening,
    end_visit,
    note_wrong_passcode,
    share_of_token,
    share_of_visit,
)
from breastrig.storage.storage import iso_utc, utc_now

PATH = "/api/shared"
OPENED_COOKIE = "breastrig_opened"
OPENED_PATH = f"{PATH}/open"
LISTED = re.compile(r"([\w-]{1,32})=([0-9a-f]{64})", re.ASCII)  # a share and what is stored of a visit
LOCKED = (
    f"This link takes no passcode any more, because {WRONG_PASSCODES} wrong ones were given; ask the person who sent "
    "it to unlock it."
)

_CHECKS = threading.BoundedSemaphore(2)  # at once: each takes 32 MB and a core for a twentieth of a second


def new_token() -> str:
    """192 random bits as 32 URL-safe characters."""
    return secrets.token_urlsafe(24)


def token_sha256(token: str) -> str:
    """The stored hash of the secret, which has too many bits to be found from it."""
    return hashlib.sha256(token.encode("utf-8", "replace")).hexdigest()


def share_of_secret(token: str) -> StoredShare:
    """The share that the secret opens.  Raises 404 for none, 410 for one that is over."""
    share = share_of_token(app_context().service.storage, token_sha256(token))
    if share is None:
        raise refuse(404, "This link opens nothing; ask the person who sent it for a new one.")
    return _still_valid(share)


def check_passcode(share: StoredShare, passcode: str | None) -> None:
    """Raises 403 for a wrong or missing passcode, 423 when the link takes none, 429 for an address that has to wait."""
    if share.passcode_hash is None:
        return
    if share.is_locked(WRONG_PASSCODES):
        raise refuse(423, LOCKED)
    if passcode is None:
        raise refuse(403, "This link needs a passcode; ask the person who sent it.")
    context, client = app_context(), client_of(request.remote_addr)
    seconds = context.passcode_delays.begin(share.id, client)
    if seconds:
        raise refuse(
            429,
            f"Too many wrong passcodes came from here; try again in {seconds} s.",
            {"Retry-After": str(seconds)},
        )
    with _CHECKS:
        is_right = check_password_hash(share.passcode_hash, passcode)
    if not is_right:
        if not note_wrong_passcode(context.service.storage, share.id, utc_now(), WRONG_PASSCODES):
            raise refuse(423, LOCKED)  # as a right one is answered then: nobody is to learn which it was
        raise refuse(403, "This is not the link's passcode; ask the person who sent it.")
    context.passcode_delays.was_right(share.id, client)


def begin_visit(response: Response, share: StoredShare) -> None:
    """Notes the opening and sets the cookie for the calls that follow.  Raises 423 when the link is locked."""
    credential = secrets.token_urlsafe(32)
    stored = _visit_hmac(credential, share.id)
    if not add_opening(app_context().service.storage, share.id, utc_now(), stored, WRONG_PASSCODES):
        raise refuse(423, LOCKED)
    _set_cookie(response, cookie_name(share.id), credential, cookie_path(share.id))
    visits = {share.id: stored}
    for listed in LISTED.finditer(request.cookies.get(OPENED_COOKIE, "")):
        earlier, its_stored = listed.groups()
        if earlier in visits or len(visits) >= COOKIES:
            end_visit(app_context().service.storage, earlier, its_stored)
            if earlier not in visits:
                _delete_cookie(response, earlier)
        else:
            visits[earlier] = its_stored
    _set_cookie(response, OPENED_COOKIE, ".".join(f"{one}={its}" for one, its in visits.items()), OPENED_PATH)


@dataclass(frozen=True, eq=False)
class Visit:
    """A share that is open in the calling browser."""

    share: StoredShare
    is_open: Callable[[], bool]  # whether it still is, asked of the rows; also after the request


def visit_of(share_id: str) -> Visit:
    """The visit that the request's cookie is of.  Raises 401 without one, 410 for a share that is over."""
    storage, stored = app_context().service.storage, _visit_hmac(_credential(share_id), share_id)

    def visited() -> StoredShare | None:
        opened_after = iso_utc(datetime.now(UTC) - timedelta(seconds=VISIT_S))
        return share_of_visit(storage, share_id, stored, opened_after)

    def is_open() -> bool:
        share = visited()
        return share is not None and share.is_valid(utc_now())

    share = visited()
    if share is None:
        raise _not_open()
    return Visit(_still_valid(share), is_open)


def close_visit(response: Response, share_id: str) -> None:
    """Ends the visit, here and for every copy of its cookie.  Raises 401 when the request comes from none."""
    if not end_visit(app_context().service.storage, share_id, _visit_hmac(_credential(share_id), share_id)):
        raise _not_open()
    _delete_cookie(response, share_id)


def cookie_name(share_id: str) -> str:
    return f"breastrig_share_{share_id}"


def cookie_path(share_id: str) -> str:
    """The only path to which the cookie is sent."""
    return f"{PATH}/{share_id}"


def _credential(share_id: str) -> str:
    credential = request.cookies.get(cookie_name(share_id), "")
    if not credential:
        raise _not_open()
    return credential


def _not_open() -> Exception:
    return refuse(401, "This link is not open in this browser; open it again as it was sent to you.")


def _still_valid(share: StoredShare) -> StoredShare:
    if not share.is_valid(utc_now()):
        raise refuse(410, "This link has expired or was revoked; ask the person who sent it for a new one.")
    return share


def _visit_hmac(credential: str, share_id: str) -> str:
    """The stored HMAC of a visit's credential: made with it as the key, over the id of its share."""
    return hmac.new(
        credential.encode("utf-8", "replace"), share_id.encode("utf-8", "replace"), hashlib.sha256
    ).hexdigest()


def _set_cookie(response: Response, name: str, value: str, path: str) -> None:
    """Without a time: it ends with the browser."""
    response.set_cookie(name, value, path=path, secure=request.is_secure, httponly=True, samesite="Strict")


def _delete_cookie(response: Response, share_id: str) -> None:
    response.delete_cookie(
        cookie_name(share_id), cookie_path(share_id), secure=request.is_secure, httponly=True, samesite="Strict"
    )
