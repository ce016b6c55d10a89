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
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from flask import Response, request
from itsdangerous import BadData, URLSafeTimedSerializer

from breastrig.api.access.person import HOLDER, Person, Role
from breastrig.api.config import Config
from breastrig.core import wall_clock
from breastrig.index import questions
from breastrig.storage.storage import Storage, iso_utc

COOKIE = "breastrig_session"
LASTS_S = 12 * 3600  # a working day; then the token is asked for again
AHEAD_S = 12 * 3600  # a clock that took local time for UTC is wrong by no more
FORGET_S = 400 * 86400  # far above both, as the clock that says when to forget may be wrong too


@dataclass(frozen=True)
class _Session:
    """What a valid signature says."""

    number: str
    began: datetime
    seen: datetime
    person: Person

    @property
    def sha256(self) -> str:
        return hashlib.sha256(self.number.encode()).hexdigest()


def start_session(response: Response, config: Config, person: Person = HOLDER) -> None:
    """A session of its own for each sign-in, whatever cookie the browser had before."""
    _set(response, config, secrets.token_urlsafe(16), None, person)


def keep_session(response: Response, config: Config, storage: Storage) -> None:
    """Somebody is at the page: the session is idle from now on, and as old as it was."""
    found = _session(config)
    if found is not None and person_in_session(config, storage) is not None:
        _set(response, config, found.number, int(found.began.timestamp()), found.person)


def person_in_session(config: Config, storage: Storage) -> Person | None:
    """Who has signed in with the browser, is not signed out, and with `--users` was at the page lately."""
    found, now = _session(config), wall_clock.now()
    if found is None:
        return None
    longest = LASTS_S if config.people is None else 60 * config.people.idle_minutes
    is_new = -AHEAD_S <= (now - found.seen).total_seconds() <= longest
    if not is_new or (now - found.began).total_seconds() > LASTS_S:
        return None
    return None if storage.index.asked(questions.is_session_over, found.sha256, iso_utc(found.began)) else found.person


def end_session(response: Response, config: Config, storage: Storage) -> None:
    """Removes the cookie, and ends the sessions of its copies."""
    found, now = _session(config), wall_clock.now()
    if found is not None:
        with storage.index.writing() as rows:
            questions.end_session(rows, found.sha256, iso_utc(now), iso_utc(now - timedelta(seconds=FORGET_S)))
    response.delete_cookie(cookie_name(), path="/", secure=request.is_secure, httponly=True, samesite="Strict")


def cookie_name() -> str:
    """For the address that the request at hand called us by; without its port where that is the scheme's own."""
    port = re.search(r":(\d{1,5})$", request.host)
    return f"{COOKIE}_{port[1]}" if port else COOKIE


def _session(config: Config) -> _Session | None:
    """That of the request's cookie, however old; None without a cookie that this service has signed."""
    signer = _signer(config)
    if signer is None:
        return None
    try:
        content, seen = signer.loads(request.cookies.get(cookie_name(), ""), return_timestamp=True)
    except BadData:
        return None
    number, began, person_id, name, role, groups = content
    began_at = seen if began is None else datetime.fromtimestamp(began, UTC)
    return _Session(number, began_at, seen, Person(person_id, name, Role(role), tuple(groups)))


def _set(response: Response, config: Config, number: str, began: int | None, person: Person) -> None:
    """Scripts cannot read the cookie, other sites' pages cannot make the browser send it.

    A person's is without a time: it ends with the browser, or before.
    """
    signer = _signer(config)
    assert signer is not None
    response.set_cookie(
        cookie_name(),
        signer.dumps([number, began, person.id, person.name, person.role, person.groups]),
        max_age=LASTS_S if config.people is None else None,
        path="/",
        secure=request.is_secure,
        httponly=True,
        samesite="Strict",
    )


def _signer(config: Config) -> URLSafeTimedSerializer | None:
    """None where nobody signs in."""
    key = config.token if config.people is None else config.people.key
    return None if key is None else URLSafeTimedSerializer(key, salt="breastrig session of a person")
