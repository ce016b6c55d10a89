"""The cookie of a browser that has signed in: a signed random number with its time.

Cookies ignore ports; so that two services on one machine keep theirs apart, its name ends with the port in the address.

It is good until it is too old, the token is another, or its browser has signed out.  The last is noted in the index,
so that a copy of the cookie is worth nothing after it, nor after a restart.

A clock that is set back makes cookies seem to come from the future.  Those that do so by hours stay good, because
nobody but the server can sign them; by more they are too old, so that none outlives a day.
"""

import hashlib
import re
import secrets
from datetime import timedelta

from flask import Response, request
from itsdangerous import BadData, URLSafeTimedSerializer

from breastrig.core import wall_clock
from breastrig.storage.documents.ended_sessions import add_ended_session, has_ended
from breastrig.storage.storage import Storage, iso_utc

COOKIE = "breastrig_session"
LASTS_S = 12 * 3600  # a working day; then the token is asked for again
AHEAD_S = 12 * 3600  # a clock that took local time for UTC is wrong by no more
FORGET_S = 400 * 86400  # far above both, as the clock that says when to forget may be wrong too


def start_session(response: Response, token: str) -> None:
    """Scripts cannot read the cookie, other sites' pages cannot make the browser send it."""
    value = _signer(token).dumps(secrets.token_urlsafe(16))
    response.set_cookie(
        cookie_name(), value, max_age=LASTS_S, path="/", secure=request.is_secure, httponly=True, samesite="Strict"
    )


def end_session(response: Response, token: str | None, storage: Storage) -> None:
    """Removes the cookie, and ends the sessions of its copies."""
    session = None if token is None else _session(token)
    if session is not None:
        now = wall_clock.now()
        add_ended_session(storage, session[0], iso_utc(now), iso_utc(now - timedelta(seconds=FORGET_S)))
    response.delete_cookie(cookie_name(), path="/", secure=request.is_secure, httponly=True, samesite="Strict")


def in_session(token: str, storage: Storage) -> bool:
    """Whether the request comes from a browser that has signed in with this token and not out again."""
    session = _session(token)
    return session is not None and not has_ended(storage, *session)


def cookie_name() -> str:
    """For the address that the request at hand called us by; without its port where that is the scheme's own."""
    port = re.search(r":(\d{1,5})$", request.host)
    return f"{COOKIE}_{port[1]}" if port else COOKIE


def _session(token: str) -> tuple[str, str] | None:
    """The session's identifier and its start; None without a valid signed cookie that is not too old."""
    value = request.cookies.get(cookie_name())
    if value is None:
        return None
    try:
        number, signed_at = _signer(token).loads(value, return_timestamp=True)
    except BadData:
        return None
    if not -AHEAD_S <= (wall_clock.now() - signed_at).total_seconds() <= LASTS_S:
        return None
    return hashlib.sha256(str(number).encode()).hexdigest(), iso_utc(signed_at)


def _signer(token: str) -> URLSafeTimedSerializer:
    return URLSafeTimedSerializer(token, salt="breastrig session")
