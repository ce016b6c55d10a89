"""Whether a request may send its body: asked when its headers are there, before a byte of the body is read.

The guards, the routes and the errors are the application's own, so that what is refused here is answered, counted
and logged like everything else.  A request that may go on meets the guards once more when its body is complete, but is
counted only here (ADMITTED says so).
"""

from typing import Any

from apiflask import APIFlask
from flask import Response, request

from breastrig.api.environ_keys import ADMITTED
from breastrig.api.errors import problem


class Admission:
    """Of one application."""

    def __init__(self, app: APIFlask) -> None:
        self._app = app

    def check(self, environ: dict[str, Any]) -> Response | int:
        """The refusal, or how many bytes the body may have."""
        with self._app.request_context(environ):
            try:
                refused = self._app.preprocess_request()
                if refused is None and request.routing_exception is not None:
                    self._app.raise_routing_exception(request)
            except Exception as error:
                try:
                    refused = self._app.handle_user_exception(error)
                except Exception as unforeseen:
                    return self._app.handle_exception(unforeseen)
            if refused is None:
                environ[ADMITTED] = True
                return int(request.max_content_length or 0)
            return self._app.finalize_request(refused)

    def refuse(self, environ: dict[str, Any], status: int, sentence: str, headers: dict[str, str]) -> Response:
        """An answer instead of the application's, counted and logged like it."""
        with self._app.request_context(environ):
            return self._app.finalize_request(problem(status, sentence, headers=headers))
