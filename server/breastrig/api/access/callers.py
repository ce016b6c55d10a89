"""Who asks, by what the request brings: the token, a session's cookie, or the name that the trusted proxy gives."""

import hmac

from flask import request

from breastrig.api.access.person import HOLDER, Person
from breastrig.api.access.session import in_session, person_in_session
from breastrig.api.config import Config
from breastrig.api.people.people import NAME_CHARACTERS, People
from breastrig.api.trusted_proxy import FORWARDED
from breastrig.storage.storage import Storage


def caller(config: Config, storage: Storage) -> Person | None:
    """Who asks for the request at hand; None for nobody who is known."""
    people = config.people
    if people is None:
        return HOLDER if config.token is None or has_token(config.token) or in_session(config.token, storage) else None
    if config.token is not None and has_token(config.token):
        return HOLDER
    return person_in_browser(people, storage)


def person_in_browser(people: People, storage: Storage) -> Person | None:
    """Who has signed in with the browser that asks."""
    if people.proxy_header is None:
        return person_in_session(people, storage)
    if FORWARDED not in request.environ:  # it does not come from the trusted proxy
        return None
    name = _only(people.proxy_header)
    groups = "" if people.proxy_groups_header is None else _only(people.proxy_groups_header)
    if not name or "," in name or len(name) > NAME_CHARACTERS or not name.isprintable():
        return None
    return people.person(name, name, {group.strip() for group in groups.split(",")} - {""})


def has_token(token: str) -> bool:
    """Whether the request's Authorization header holds the token."""
    kind, _, given = request.headers.get("Authorization", "").partition(" ")
    return kind.lower() == "bearer" and hmac.compare_digest(given.strip().encode(), token.encode())


def _only(header: str) -> str:
    """The header's value; empty where it came twice: one of them may be the client's own."""
    raw = [value for name, value in request.environ.get("asgi.scope", {}).get("headers", ()) if _is(name, header)]
    if len(raw) > 1:
        return ""
    return request.headers.get(header, "").encode("latin-1", "replace").decode("utf-8", "replace").strip()


def _is(raw_name: bytes, header: str) -> bool:
    return raw_name.decode("latin-1").lower() == header.lower()
