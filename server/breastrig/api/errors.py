"""Every error as RFC 9457 problem details: the only place that turns an error into a status."""

import errno
import json
import logging
import shutil
import sqlite3
from collections.abc import Mapping
from functools import partial
from http import HTTPStatus
from types import MappingProxyType
from typing import Any

from apiflask import APIFlask, HTTPError
from flask import Response, request
from pydantic import ValidationError
from werkzeug.exceptions import HTTPException

from breastrig.api.wire.patients import PLAIN
from breastrig.core import errors
from breastrig.index.file import is_full
from breastrig.storage.storage import Storage

log = logging.getLogger(__name__)

NO_ROOM_BYTES = 2**20  # less is free on a full disk: what tables and files need at once

STATUS: tuple[tuple[type[errors.BreastRigError], int], ...] = (  # the first that fits counts
    (errors.NotFound, 404),
    (errors.Conflict, 409),
    (errors.NeedsYes, 409),
    (errors.TooLarge, 413),
    (errors.TooMany, 429),
    (errors.BadModel, 503),  # the model is the service's own, the caller cannot mend it
    (errors.NotRemoved, 500),  # what was asked for has not been done, and only who runs the service can help
    (errors.NotSent, 502),
    (errors.BreastRigError, 422),
)
SENTENCES = {
    400: "The request cannot be understood; check that its body is complete and well-formed.",
    404: "There is nothing at this address; /api/docs lists what there is.",
    405: "This address does not take {method}; /api/docs lists what it takes.",
    413: "The request is larger than this service takes.",
    415: "The request's content type is not the one that this address takes.",
    416: "The range that was asked for lies beyond the end of this file.",
    500: "Something went wrong inside BreastRig; the server's log says what.",
}
NOT_OF_FORM = {  # by regular expression
    PLAIN: "Line breaks and other control characters are not taken; leave them out",
}
NO_FILE = "No file was sent under this name; send it as this field of multipart/form-data"
IN_OTHER_WORDS = {"Value error, Not a valid file.": NO_FILE}  # of the libraries' messages
OTHER_FORM = "This text is not of the form that is taken here; /api/docs describes it"


def too_large(most: int) -> str:
    """The sentence for a body of more than so many bytes."""
    shown = f"{most // 1_000_000} MB" if most >= 1_000_000 else f"{most // 1000} kB"
    return f"The request is larger than {shown}."


def problem(
    status: int,
    detail: str,
    *,
    headers: Any = (),
    fields: list[dict[str, str]] | None = None,
    question: dict[str, Any] | None = None,
) -> Response:
    """One problem-details answer; `detail` is one sentence."""
    body: dict[str, Any] = {
        "type": "about:blank",
        "title": HTTPStatus(status).phrase,
        "status": status,
        "detail": detail,
    }
    if fields:
        body["errors"] = fields
    if question:
        body["question"] = question
    response = Response(json.dumps(body), status, mimetype="application/problem+json")
    for name, value in dict(headers).items():
        response.headers[name] = value
    response.headers["Cache-Control"] = "no-store"
    return response


def refuse(status: int, sentence: str, headers: Mapping[str, str] = MappingProxyType({})) -> HTTPException:
    """An HTTP error with a sentence of ours, to raise in a view."""
    return HTTPException(response=problem(status, sentence, headers=headers))


def register_errors(app: APIFlask, storage: Storage) -> None:
    in_trouble = partial(_index_trouble, storage)
    app.register_error_handler(errors.BreastRigError, _breastrig_error)
    app.register_error_handler(HTTPError, _validation_error)
    app.register_error_handler(HTTPException, _http_error)
    too_deep = "The request's JSON is nested too deeply."
    app.register_error_handler(RecursionError, lambda _error: problem(400, too_deep))
    app.register_error_handler(sqlite3.Error, in_trouble)
    app.register_error_handler(OSError, _disk_trouble)


def _breastrig_error(error: errors.BreastRigError) -> Response:
    status = next(status for kind, status in STATUS if isinstance(error, kind))
    headers = {"Retry-After": str(error.retry_after_s)} if isinstance(error, errors.TooMany) else {}
    question = {"problem": error.problem, **error.question} if isinstance(error, errors.NeedsAnswer) else None
    return problem(status, str(error), headers=headers, question=question)


def _http_error(error: HTTPException) -> Response:
    """Errors of Flask itself; the catch-all comes here as a 500."""
    status = error.code or 500
    detail = SENTENCES.get(status, error.name + ".").format(method=request.method)
    headers = {name: value for name, value in error.get_headers() if name.lower() not in ("content-type",)}
    return problem(status, detail, headers=headers)


def _validation_error(error: HTTPError) -> Response:
    """A body or query that does not have the documented shape."""
    fields: list[dict[str, str]] = []
    if isinstance(error.__cause__, ValidationError):
        for found in error.__cause__.errors(include_url=False, include_input=False):
            name = ".".join(str(part) for part in found["loc"])[:200]
            pattern = found["ctx"]["pattern"] if found["type"] == "string_pattern_mismatch" else None
            said = IN_OTHER_WORDS.get(found["msg"], found["msg"])
            message = said if pattern is None else NOT_OF_FORM.get(pattern, OTHER_FORM)
            fields.append({"field": name, "message": message[:300]})
    if not fields:
        return problem(error.status_code, SENTENCES.get(error.status_code, f"{error.message}."))
    first = fields[0]
    where = f"{first['field']}: " if first["field"] else ""
    more = f" ({len(fields) - 1} more)" if len(fields) > 1 else ""
    return problem(error.status_code, f"{where}{first['message'].rstrip('.')}{more}.", fields=fields[:50])


def _index_trouble(storage: Storage, error: sqlite3.Error) -> Response:
    if is_full(error) and shutil.disk_usage(storage.root).free < NO_ROOM_BYTES:
        return _disk_is_full()
    log.error("the index cannot be used: %s", error)
    return _later("The service cannot store anything at the moment; its disk may be full. Try again later.")


def _disk_trouble(error: OSError) -> Response:
    if error.errno == errno.EIO:
        log.error("files cannot be reached: %s", error.strerror)
        return _later("The service cannot reach its files at the moment; try again later.")
    if error.errno not in (errno.ENOSPC, errno.EDQUOT):
        raise error
    return _disk_is_full()


def _later(detail: str) -> Response:
    return problem(503, detail, headers={"Retry-After": "10"})


def _disk_is_full() -> Response:
    log.error("the disk is full")
    return problem(507, "The service's disk is full; nothing was kept. Free space, or delete scans, and try again.")
