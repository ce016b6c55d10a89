"""The cookie of a browser that has signed in: a signed random number with its time.

Cookies ignore ports; so that two services on one machine keep theirs apart, its name ends with the port in the address.

It is good until it is too old, the token is another, or its browser has signed out.  The last is noted in the index,
so that a copy of the cookie is worth nothing after it, nor after a restart.

With `--users` it names the person too, is signed by a key that lives as long as the service, and is over when nobody
was at the page for a while: only `keep_session`, which the page asks for when somebody moves in it, makes it good for
longer.

A clock that is set back makes cookies seem to come from the future.  Those that do so by hours stay good, because
nobody but the server can sign them; by more they are too old, so that none outlives a day.
"""

import hashlib
import re
import secrets
from datetime import UTC, datetime, timedelta
from typing import Any

from flask import Response, request
from itsdangerous import BadData, URLSafeTimedSerializer

from breastrig.api.access.person import Person, Role
from breastrig.api.people.people import People
from breastrig.core import wall_clock
from breastrig.storage.documents.ended_sessions import add_ended_session, has_ended
from breastrig.storage.storage import Storage, iso_utc

COOKIE = "breastrig_session"
LASTS_S = 12 * 3600  # a working day; then the token is asked for again
LASTS = timedelta(seconds=LASTS_S)
AHEAD_S = 12 * 3600  # a clock that took local time for UTC is wrong by no more
FORGET_S = 400 * 86400  # far above both, as the clock that says when to forget may be wrong too


def start_session(response: Response, token: str) -> None:
    """Scripts cannot read the cookie, other sites' pages cannot make the browser send it."""
    value = _signer(token).dumps(secrets.token_urlsafe(16))
    response.set_cookie(
        cookie_name(), value, max_age=LASTS_S, path="/", secure=request.is_secure, httponly=True, samesite="Strict"
    )


def start_persons_session(response: Response, people: People, person: Person) -> None:
    """A session of its own for each sign-in, whatever cookie the browser had before."""
    began = int(wall_clock.now().timestamp())
    _set_persons(
        response, people, [secrets.token_urlsafe(16), began, person.id, person.name, person.role, person.groups]
    )


def keep_session(response: Response, people: People, storage: Storage) -> None:
    """Somebody is at the page: the session is idle from now on, and as old as it was."""
    found = _persons(people)
    if found is not None and person_in_session(people, storage) is not None:
        _set_persons(response, people, found[0])


def person_in_session(people: People, storage: Storage) -> Person | None:
    """The person who has signed in with the browser, is not signed out, and was at the page lately."""
    found = _persons(people)
    if found is None:
        return None
    (number, began, person_id, name, role, groups), seen = found
    began_at = datetime.fromtimestamp(began, UTC)
    idle = wall_clock.now() - seen
    is_new = -AHEAD_S <= idle.total_seconds() <= 60 * people.idle_minutes and wall_clock.now() - began_at <= LASTS
    if not is_new or has_ended(storage, _sha256(number), iso_utc(began_at)):
        return None
    return Person(person_id, name, Role(role), tuple(groups))


def end_session(response: Response, token: str | None, people: People | None, storage: Storage) -> None:
    """Removes the cookie, and ends the sessions of its copies."""
    if people is not None:
        persons = _persons(people)
        ended = None if persons is None else _sha256(persons[0][0])
    else:
        session = None if token is None else _session(token)
        ended = None if session is None else session[0]
    if ended is not None:
        now = wall_clock.now()
        add_ended_session(storage, ended, iso_utc(now), iso_utc(now - timedelta(seconds=FORGET_S)))
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
    return _sha256(number), iso_utc(signed_at)


def _set_persons(response: Response, people: People, session: list[Any]) -> None:
    """Without a time: it ends with the browser, or before."""
    value = _persons_signer(people).dumps(session)
    response.set_cookie(cookie_name(), value, path="/", secure=request.is_secure, httponly=True, samesite="Strict")


def _persons(people: People) -> tuple[list[Any], datetime] | None:
    """The content of a signed cookie, and when it was signed."""
    try:
        content, seen = _persons_signer(people).loads(request.cookies.get(cookie_name(), ""), return_timestamp=True)
    except BadData:
        return None
    return content, seen


def _persons_signer(people: People) -> URLSafeTimedSerializer:
    return URLSafeTimedSerializer(people.key, salt="breastrig session of a person")


def _sha256(number: object) -> str:
    return hashlib.sha256(str(number).encode()).hexdigest()


def _signer(token: str) -> URLSafeTimedSerializer:
    return URLSafeTimedSerializer(token, salt="breastrig session")
