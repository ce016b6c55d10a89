"""The built page, and the page that says how to build it."""

import mimetypes
from os.path import isfile
from pathlib import Path

from flask import Blueprint, Response, abort, render_template, request
from werkzeug.routing import BaseConverter
from werkzeug.security import safe_join

from breastrig.api.access.callers import caller
from breastrig.api.answers import BINARY, CHECK_AGAIN, FOR_EVER, public_answer
from breastrig.api.app_context import config, storage
from breastrig.api.routes.sign_in import lead_to, sign_in_with
from breastrig.core.assets import asset_folder

page = Blueprint("page", __name__, template_folder="templates")


class PageFile(BaseConverter):
    """A path of the page; addresses of the API are never files of the page, so they keep their own errors."""

    part_isolating = False
    regex = r"(?!api(?:/|$)|(?:healthz|readyz|metrics)$)[^/].*?"


@page.get("/")
def index() -> Response:
    """The page; its address never changes, so the browser asks each time.

    With the token in it, the address begins a session.  Without a session the page could show nothing but errors: then
    the sign-in page comes first.
    """
    given = request.args.get("token")
    has_session = caller(config, storage) is not None
    if given is not None and not has_session:
        return sign_in_with(given)
    if given is not None:
        return lead_to("/")
    if not has_session and request.headers.get("Sec-Fetch-Site") == "cross-site":
        # A link or file led here: the browser sends our cookie only when our own page asks.
        return Response(mimetype="text/html", headers={"Refresh": "0; url=/", "Cache-Control": "no-store"})
    if not has_session:
        return lead_to("/sign-in")
    folder = _folder()
    if not (folder / "index.html").is_file():
        return Response(
            render_template("not_built.html"), 503, mimetype="text/html", headers={"Cache-Control": "no-store"}
        )
    return _file(folder, "index.html", CHECK_AGAIN)


@page.get("/<page_file:name>")
def asset(name: str) -> Response:
    """A file of the page; those below assets/ carry their hash in their name."""
    return _file(_folder(), name, FOR_EVER if name.startswith("assets/") else CHECK_AGAIN)


def _folder() -> Path:
    return config.web or asset_folder("web")


def _file(folder: Path, name: str, caching: str) -> Response:
    path = safe_join(str(folder), name)
    if path is None or not isfile(path):  # pathlib's own raises for a name that is too long
        abort(404)
    media_type = mimetypes.guess_type(name)[0] or BINARY
    return public_answer(Path(path).read_bytes(), media_type, caching)
