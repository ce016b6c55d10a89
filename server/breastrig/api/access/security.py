"""Guards before each request and headers after it.

Reading the scans of patients must not be possible from a web page that happens to be open in the same browser:
  * the Host header must name this machine (a foreign name that resolves to 127.0.0.1 is DNS rebinding),
  * a request that changes something must come from our own page when the browser says where it comes from,
  * with a token set, every call below /api must carry it, or the cookie of a browser that has signed in with it,
  * with users, every call below /api must come from one of them whose role it allows, and it is about a patient of
    theirs.
"""

from urllib.parse import urlsplit

from apiflask import APIFlask
from flask import Response, current_app, request

from breastrig.api.access.callers import caller
from breastrig.api.access.person import NOBODY, current_person, groups_in_reach, is_visitor, note_person
from breastrig.api.access.rate_limits import RateLimits
from breastrig.api.access.roles import SAFE_METHODS, WORDS, least_role
from breastrig.api.config import Config
from breastrig.api.errors import SENTENCES, refuse, too_large
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


def register_security(app: APIFlask, config: Config, storage: Storage, rates: RateLimits) -> None:
    """Adds the guards; the first one that refuses raises the answer.  None of them needs the request's body."""

    @app.before_request
    def guard() -> None:
        client_key.set(client_of(request.remote_addr))
        _check_host(config)
        _check_origin()
        _check_person(config, storage, rates)
        _check_role()
        _check_reach(storage)
        _check_names()
        if _is_upload():
            rates.check("upload")
        _limit_body(config)

    @app.after_request
    def add_headers(response: Response) -> Response:
        for name, value in HEADERS.items():
            response.headers.setdefault(name, value)
        response.headers.setdefault("Cache-Control", "no-store")
        return response


def _check_host(config: Config) -> None:
    allowed = config.allowed_hosts
    try:
        name = urlsplit(f"//{request.headers.get('Host', '')}").hostname
    except ValueError:
        name = None
    if allowed is not None and name not in allowed:
        raise refuse(421, "This server answers only under its own name; open it as http://localhost with its port.")


def _check_origin() -> None:
    origin, own = request.headers.get("Origin"), f"{request.scheme}://{request.headers.get('Host', '')}"
    is_foreign = (
        request.headers.get("Sec-Fetch-Site") in ("cross-site", "same-site")
        if origin is None
        else netloc_of(origin) != netloc_of(own)
    )
    if is_foreign and request.method not in SAFE_METHODS:
        raise refuse(403, "This request comes from another web page; only BreastRig's own page may change things.")


def netloc_of(origin: str) -> str:
    """Host and port of an origin, lower case, without the scheme's own port; empty for "null" and for what is none."""
    try:
        parts = urlsplit(origin)
    except ValueError:
        return ""
    return parts.netloc.lower().removesuffix(USUAL_PORTS[parts.scheme]) if parts.scheme in USUAL_PORTS else ""


def _check_person(config: Config, storage: Storage, rates: RateLimits) -> None:
    """Notes who asks, refuses nobody who is known; the right token passes however many wrong ones came before."""
    if config.people is not None:
        note_person(NOBODY)
    if not request.path.startswith("/api/") or is_visitor():
        return
    person = caller(config, storage)
    if person is None:
        count_guess(rates)
        detail = (
            "This service needs its token: sign in at /sign-in, or send it as a bearer in the Authorization header."
            if config.people is None
            else "Nobody is signed in; sign in at /sign-in."
        )
        raise refuse(401, detail, {"WWW-Authenticate": "Bearer"})
    note_person(person)


def _check_role() -> None:
    least = None if request.endpoint is None else least_role(request.endpoint, request.method)
    if least is not None and not current_person().role.includes(least):
        raise refuse(403, f"You {WORDS[least]}; ask an administrator of your clinic for more.")


def _check_reach(storage: Storage) -> None:
    """Raises NotFound for what is of a patient of other groups, or of nobody, as for what is not there."""
    if groups_in_reach() is None:
        return
    given = request.view_args or {}
    if "patient_id" in given:
        storage.case(given["patient_id"])
    if "scan_id" in given:
        storage.case_of_scan(given["scan_id"])
    if "fit_id" in given:
        storage.case_of_fit(given["fit_id"])


def count_guess(rates: RateLimits) -> None:
    """To be called when the request may not pass; raises the 429 for one wrong token too many."""
    if "Authorization" in request.headers:
        rates.check("bearer")
        rates.check("bearer of anybody", "anybody")


def _check_names() -> None:
    """No id, and no file of the page, has so long a name; to the disk it would be an error, not an unknown name."""
    if any(len(part.encode()) > NAME_BYTES for part in request.path.split("/")):
        raise refuse(404, SENTENCES[404])


def _is_upload() -> bool:
    return (request.endpoint, request.method) == ("scans.upload_scan", "POST")


def _limit_body(config: Config) -> None:
    """Refuses a wrong content type or too large a body before any of it is read."""
    view = current_app.view_functions.get(request.endpoint or "")
    expected = getattr(view, "_spec", {}).get("content_type") if view else None
    takes_body = expected is not None and request.method not in SAFE_METHODS
    largest: dict[str | None, int] = {
        "application/json": FORM_BYTES if is_visitor() else config.json_bytes,
        "multipart/form-data": config.uploads.zip_bytes if _is_upload() else config.uploads.file_bytes,
    }
    request.max_content_length = largest.get(expected, FORM_BYTES) if takes_body else FORM_BYTES
    if "Transfer-Encoding" in request.headers:
        raise refuse(411, "Send the body with its length (Content-Length), not in chunks.")
    if request.content_length is not None and request.content_length > request.max_content_length:
        raise refuse(413, too_large(request.max_content_length))
    if takes_body and request.mimetype != expected:
        raise refuse(415, f"Send the body as {expected}, not {request.mimetype or 'without a content type'}.")
