"""Who asks, by what the request brings: the token, a session's cookie, or the name that the trusted proxy gives."""

import hmac

from flask import request

from breastrig.api.access.person import HOLDER, Person
from breastrig.api.access.session import person_in_session
from breastrig.api.config import Config
from breastrig.api.people.people import NAME_CHARACTERS
from breastrig.api.trusted_proxy import FORWARDED
from breastrig.storage.storage import Storage


def caller(config: Config, storage: Storage) -> Person | None:
    """Who asks for the request at hand; None for nobody who is known."""
    needs_none = config.token is None and config.people is None
    if needs_none or (config.token is not None and has_token(config.token)):
        return HOLDER
    return person_in_browser(config, storage)


def person_in_browser(config: Config, storage: Storage) -> Person | None:
    """Who has signed in with the browser that asks."""
    people = config.people
    if people is None or people.proxy_header is None:
        return person_in_session(config, storage)
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
    names = [name.decode("latin-1").lower() for name, _ in request.environ.get("asgi.scope", {}).get("headers", ())]
    if names.count(header.lower()) > 1:
        return ""
    return request.headers.get(header, "").encode("latin-1", "replace").decode("utf-8", "replace").strip()
