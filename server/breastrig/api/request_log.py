"""A line for each request that was answered, for those who run the service: what was called and how it went.

Never who: no address, no id (the route is named by its pattern), no query, no header.  The line is written when the
answer has been sent or its reader has left, so that the time of a stream is the time it was open.

An error of ours is logged with its traceback, but what the address held of it is taken out: errors quote the names of
files, and those hold ids.
"""

import logging
import time
import traceback
from urllib.parse import quote

from apiflask import APIFlask
from flask import Response, g, request

from breastrig.core.log_lines import FIELDS

SHORT = 5  # characters; no id is so short, and words of the traceback are
METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})

BEGAN = "breastrig_began"  # in Flask's g: time.perf_counter(), set by `register_metrics`

log = logging.getLogger("breastrig.requests")


def route_of_request() -> tuple[str, str]:
    """(method, pattern of the route) of the request at hand; made-up methods and addresses have no name here."""
    route = request.url_rule.rule if request.url_rule is not None else "none"
    return request.method if request.method in METHODS else "other", route


def register_request_log(app: APIFlask) -> None:
    """To be registered before the guards, so that what they refuse is logged too."""

    @app.after_request
    def end(response: Response) -> Response:
        method, route = route_of_request()
        began, status = g.get(BEGAN, time.perf_counter()), response.status_code
        response.call_on_close(lambda: _log_answer(method, route, status, time.perf_counter() - began))
        return response


def log_error_of_request(error: BaseException | None) -> None:
    """Logs an unexpected error of the current request."""
    method, route = route_of_request()
    text = without_address("".join(traceback.format_exception(error)))
    fields = {"method": method, "route": route, "traceback": text}
    log.error("%s %s ended in %s", method, route, type(error).__name__, extra={FIELDS: fields})


def without_address(text: str) -> str:
    """The text without any part of the request's address that its route does not have."""
    route = "" if request.url_rule is None else request.url_rule.rule
    parts = {part for part in (request.path, *request.path.split("/"), *request.args.values()) if len(part) >= SHORT}
    for part in sorted(parts - {route, *route.split("/")}, key=len, reverse=True):
        for form in {part, repr(part)[1:-1], quote(part)}:
            text = text.replace(form, "...")
    return text


def _log_answer(method: str, route: str, status: int, seconds: float) -> None:
    milliseconds = round(1000.0 * seconds, 1)
    fields = {"method": method, "route": route, "status": status, "duration_ms": milliseconds}
    log.info("%s %s %d in %.1f ms", method, route, status, milliseconds, extra={FIELDS: fields})
