"""Guards before each request and headers after it.

Reading the scans of patients must not be possible from a web page that happens to be open in the same browser:
  * the Host header must name this machine (a foreign name that resolves to 127.0.0.1 is DNS rebinding),
  * a request that changes something must come from our own page when the browser says where it comes from,
  * with a token set, every call below /api must carry it, or the cookie of a browser that has signed in with it.
"""

import hmac
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any
from urllib.parse import urlsplit

from apiflask import APIFlask
from flask import Response, current_app, request
from werkzeug.exceptions import HTTPException

from breastrig.api.config import Config
from breastrig.api.errors import problem
from breastrig.api.session import in_session
from breastrig.storage.storage import Storage

POLICY = "; ".join(
    (
        "default-src 'self'",
        "img-src 'self' blob: data:",
        "worker-src 'self' blob:",
        "connect-src 'self' blob:",
        "style-src 'self'",
        "object-src 'none'",
        "base-uri 'none'",
        "form-action 'self'",
        "frame-ancestors 'none'",
    )
)
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "X-Robots-Tag": "noindex",
}
SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})


def register_security(app: APIFlask, config: Config, storage: Storage) -> None:
    """Adds the guards; the first one that refuses gives the answer."""

    @app.before_request
    def guard() -> Response | None:
        return _wrong_host(config) or _foreign_origin() or _wrong_token(config, storage) or _limit_body(config)

    @app.after_request
    def add_headers(response: Response) -> Response:
        for name, value in HEADERS.items():
            response.headers.setdefault(name, value)
        response.headers.setdefault("Cache-Control", "no-store")
        return response


def _wrong_host(config: Config) -> Response | None:
    allowed = config.allowed_hosts
    if allowed is None:
        return None
    try:
        name = urlsplit(f"//{request.headers.get('Host', '')}").hostname
    except ValueError:
        name = None
    if name in allowed:
        return None
    return problem(421, "This server answers only under its own name; open it as http://localhost with its port.")


def _foreign_origin() -> Response | None:
    if request.method in SAFE_METHODS:
        return None
    origin = request.headers.get("Origin")
    if origin is not None and urlsplit_netloc(origin) != request.headers.get("Host", "").lower():
        return problem(403, "This request comes from another web page; only BreastRig's own page may change things.")
    if origin is None and request.headers.get("Sec-Fetch-Site") in ("cross-site", "same-site"):
        return problem(403, "This request comes from another web page; only BreastRig's own page may change things.")
    return None


def urlsplit_netloc(origin: str) -> str:
    """Host and port of an origin, lower case; empty for "null" and for what is none."""
    try:
        parts = urlsplit(origin)
    except ValueError:
        return ""
    return parts.netloc.lower() if parts.scheme in ("http", "https") else ""


def _wrong_token(config: Config, storage: Storage) -> Response | None:
    if config.token is None or not request.path.startswith("/api/") or _is_for_visitors():
        return None
    kind, _, given = request.headers.get("Authorization", "").partition(" ")
    if kind.lower() == "bearer" and hmac.compare_digest(given.strip().encode(), config.token.encode()):
        return None
    if in_session(config.token, storage):
        return None
    return problem(
        401,
        "This service needs its token: sign in at /sign-in, or send it as a bearer in the Authorization header.",
        headers={"WWW-Authenticate": "Bearer"},
    )


def _is_for_visitors() -> bool:
    """Share links bring a credential of their own, which these calls check themselves."""
    return (request.endpoint or "").startswith("shared.")


def _limit_body(config: Config) -> Response | None:
    """Refuses a wrong content type or too large a body before any of it is read."""
    view = current_app.view_functions.get(request.endpoint or "")
    expected = getattr(view, "_spec", {}).get("content_type") if view else None
    if expected is None or request.method in SAFE_METHODS:
        return None
    if expected == "application/json":
        request.max_content_length = config.json_bytes
    if request.content_length is not None and request.content_length > (request.max_content_length or 0):
        return problem(413, f"The request is larger than {(request.max_content_length or 0) // 1_000_000} MB.")
    if request.mimetype != expected:
        return problem(415, f"Send the body as {expected}, not {request.mimetype or 'without a content type'}.")
    return None


class Refused(HTTPException):
    """An HTTP error with a sentence, and perhaps headers, of ours."""

    def __init__(self, status: int, sentence: str, headers: Mapping[str, str]) -> None:
        super().__init__(sentence)
        self.code = status
        self.ours = True
        self._headers = headers

    def get_headers(self, *args: Any, **kwargs: Any) -> list[tuple[str, str]]:
        return [*super().get_headers(*args, **kwargs), *self._headers.items()]


def refuse(status: int, sentence: str, headers: Mapping[str, str] = MappingProxyType({})) -> HTTPException:
    """An HTTP error with a sentence of ours, to raise in a view."""
    return Refused(status, sentence, headers)
