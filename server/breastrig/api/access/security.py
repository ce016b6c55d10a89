"""Guards before each request and headers after it.

Reading the scans of patients must not be possible from a web page that happens to be open in the same browser:
  * the Host header must name this machine (a foreign name that resolves to 127.0.0.1 is DNS rebinding),
  * a request that changes something must come from our own page when the browser says where it comes from,
  * with a token set, every call below /api must carry it, or the cookie of a browser that has signed in with it.
"""

import hmac
from urllib.parse import urlsplit

from apiflask import APIFlask
from flask import Response, current_app, request

from breastrig.api.access.rate_limits import RateLimits
from breastrig.api.access.session import in_session
from breastrig.api.config import Config
from breastrig.api.errors import SENTENCES, problem, refuse, too_large
from breastrig.api.trusted_proxy import client_of
from breastrig.execution.pool import client_key
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
USUAL_PORTS = {"http": ":80", "https": ":443"}
NAME_BYTES = 128  # of one part of an address
FORM_BYTES = 10_000  # of visitors' requests, and of those whose body is no JSON and no file: a token is shorter
SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})


def register_security(app: APIFlask, config: Config, storage: Storage, rates: RateLimits) -> None:
    """Adds the guards; the first one that refuses gives the answer.  None of them needs the request's body."""

    @app.before_request
    def guard() -> Response | None:
        client_key.set(client_of(request.remote_addr))
        refused = _wrong_host(config) or _foreign_origin() or _wrong_token(config, storage, rates)
        if refused is None:
            _refuse_long_names()
            _count_upload(rates)
            refused = _limit_body(config)
        return refused

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
    if origin is not None and netloc_of(origin) != netloc_of(f"{request.scheme}://{request.headers.get('Host', '')}"):
        return problem(403, "This request comes from another web page; only BreastRig's own page may change things.")
    if origin is None and request.headers.get("Sec-Fetch-Site") in ("cross-site", "same-site"):
        return problem(403, "This request comes from another web page; only BreastRig's own page may change things.")
    return None


def netloc_of(origin: str) -> str:
    """Host and port of an origin, lower case, without the scheme's own port; empty for "null" and for what is none."""
    try:
        parts = urlsplit(origin)
    except ValueError:
        return ""
    return parts.netloc.lower().removesuffix(USUAL_PORTS[parts.scheme]) if parts.scheme in USUAL_PORTS else ""


def _wrong_token(config: Config, storage: Storage, rates: RateLimits) -> Response | None:
    """The refusal of a wrong token; None for the right one, however many wrong ones came before."""
    if config.token is None or not request.path.startswith("/api/") or _is_for_visitors():
        return None
    if has_token(config.token) or in_session(config.token, storage):
        return None
    count_guess(rates)
    return problem(
        401,
        "This service needs its token: sign in at /sign-in, or send it as a bearer in the Authorization header.",
        headers={"WWW-Authenticate": "Bearer"},
    )


def count_guess(rates: RateLimits) -> None:
    """To be called when the request may not pass; raises the 429 for one wrong token too many."""
    if "Authorization" in request.headers:
        rates.check("bearer")
        rates.check("bearer of anybody", "anybody")


def has_token(token: str) -> bool:
    """Whether the request's Authorization header holds the token."""
    kind, _, given = request.headers.get("Authorization", "").partition(" ")
    return kind.lower() == "bearer" and hmac.compare_digest(given.strip().encode(), token.encode())


def _is_for_visitors() -> bool:
    """Whether the call is for visitors of share links, who bring a credential that the call checks."""
    return (request.endpoint or "").startswith("shared.")


def _refuse_long_names() -> None:
    """No id, and no file of the page, has so long a name; to the disk it would be an error, not an unknown name."""
    if any(len(part.encode()) > NAME_BYTES for part in request.path.split("/")):
        raise refuse(404, SENTENCES[404])


def _count_upload(rates: RateLimits) -> None:
    if _is_upload():
        rates.check("upload")


def _is_upload() -> bool:
    return (request.endpoint, request.method) == ("scans.upload_scan", "POST")


def _limit_body(config: Config) -> Response | None:
    """Refuses a wrong content type or too large a body before any of it is read."""
    view = current_app.view_functions.get(request.endpoint or "")
    expected = getattr(view, "_spec", {}).get("content_type") if view else None
    takes_body = expected is not None and request.method not in SAFE_METHODS
    largest: dict[str | None, int] = {
        "application/json": FORM_BYTES if _is_for_visitors() else config.json_bytes,
        "multipart/form-data": config.uploads.zip_bytes if _is_upload() else config.uploads.file_bytes,
    }
    request.max_content_length = largest.get(expected, FORM_BYTES) if takes_body else FORM_BYTES
    if "Transfer-Encoding" in request.headers:
        return problem(411, "Send the body with its length (Content-Length), not in chunks.")
    if request.content_length is not None and request.content_length > request.max_content_length:
        return problem(413, too_large(request.max_content_length))
    if takes_body and request.mimetype != expected:
        return problem(415, f"Send the body as {expected}, not {request.mimetype or 'without a content type'}.")
    return None
