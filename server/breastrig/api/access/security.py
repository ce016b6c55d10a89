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
from breastrig.api.access.roles import WORDS, least_role
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
        refused = _wrong_host(config) or _foreign_origin() or _unknown(config, storage, rates) or _forbidden()
        if refused is None:
            _check_reach(storage)
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


def _unknown(config: Config, storage: Storage, rates: RateLimits) -> Response | None:
    """The refusal of nobody who is known; None for the right token, however many wrong ones came before."""
    if config.people is not None:
        note_person(NOBODY)
    if not request.path.startswith("/api/") or is_visitor():
        return None
    person = caller(config, storage)
    if person is not None:
        note_person(person)
        return None
    count_guess(rates)
    detail = (
        "This service needs its token: sign in at /sign-in, or send it as a bearer in the Authorization header."
        if config.people is None
        else "Nobody is signed in; sign in at /sign-in."
    )
    return problem(401, detail, headers={"WWW-Authenticate": "Bearer"})


def _forbidden() -> Response | None:
    """The refusal of a call that the person's role does not allow."""
    least = None if request.endpoint is None else least_role(request.endpoint, request.method)
    person = current_person()
    if least is None or person.role.includes(least):
        return None
    return problem(403, f"You {WORDS[least]}; ask an administrator of your clinic for more.")


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
        "application/json": FORM_BYTES if is_visitor() else config.json_bytes,
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
