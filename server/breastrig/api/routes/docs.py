"""The API's own description: openapi.json, and one plain page made of it (no script, nothing from elsewhere)."""

from typing import Any

from flask import Blueprint, Response, current_app, render_template

from breastrig.api.answers import BINARY, CHECK_AGAIN, JSON, bytes_answer
from breastrig.api.openapi import openapi_bytes

docs = Blueprint("docs", __name__, url_prefix="/api", template_folder="templates")


@docs.get("/openapi.json")
def show_openapi() -> Response:
    return bytes_answer(openapi_bytes(_document()), JSON, CHECK_AGAIN)


@docs.get("/docs")
def show_docs() -> Response:
    html = render_template("docs.html", document=_document(), binary=BINARY)
    return bytes_answer(html.encode(), "text/html", CHECK_AGAIN)


@docs.get("/docs/style.css")
def show_style() -> Response:
    return bytes_answer(render_template("docs.css").encode(), "text/css", CHECK_AGAIN)


def _document() -> dict[str, Any]:
    document: dict[str, Any] = current_app._get_spec("json")  # type: ignore[attr-defined]  # APIFlask keeps it
    return document
