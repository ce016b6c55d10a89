"""The API's own description: openapi.json, and one plain page made of it (no script, nothing from elsewhere)."""

from typing import Any

from apiflask import APIFlask
from flask import Blueprint, Response, current_app, jsonify, render_template

from breastrig.api.answers import CHECK_AGAIN

docs = Blueprint("docs", __name__, url_prefix="/api", template_folder="templates")


@docs.get("/openapi.json")
def show_openapi() -> Response:
    response = jsonify(_document())
    response.headers["Cache-Control"] = CHECK_AGAIN
    return response


@docs.get("/docs")
def show_docs() -> Response:
    document = _document()
    operations = [
        {"method": method.upper(), "path": path, **operation, "answers": _answers(operation)}
        for path, methods in document["paths"].items()
        for method, operation in methods.items()
    ]
    groups = {tag["name"]: [one for one in operations if one["tags"] == [tag["name"]]] for tag in document["tags"]}
    html = render_template("docs.html", info=document["info"], groups=groups, schemas=document["components"]["schemas"])
    return Response(html, mimetype="text/html", headers={"Cache-Control": CHECK_AGAIN})


@docs.get("/docs/style.css")
def show_style() -> Response:
    return Response(render_template("docs.css"), mimetype="text/css", headers={"Cache-Control": CHECK_AGAIN})


def _document() -> dict[str, Any]:
    assert isinstance(current_app, APIFlask) or hasattr(current_app, "_get_spec")
    document: dict[str, Any] = current_app._get_spec("json")  # type: ignore[attr-defined]
    return document


def _answers(operation: dict[str, Any]) -> list[tuple[str, str, str]]:
    """(status, description, schema or media type) of each answer."""
    rows = []
    for status, answer in operation["responses"].items():
        shapes = []
        for media_type, content in answer.get("content", {}).items():
            reference = content.get("schema", {}).get("$ref", "")
            shapes.append(reference.rsplit("/", 1)[-1] or media_type)
        rows.append((status, answer.get("description", ""), ", ".join(shapes)))
    return rows
