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
    document = _document()
    schemas = {name: _fields(schema) for name, schema in document["components"]["schemas"].items()}
    html = render_template("docs.html", info=document["info"], groups=_groups(document), schemas=schemas)
    return bytes_answer(html.encode(), "text/html", CHECK_AGAIN)


@docs.get("/docs/style.css")
def show_style() -> Response:
    return bytes_answer(render_template("docs.css").encode(), "text/css", CHECK_AGAIN)


def _document() -> dict[str, Any]:
    document: dict[str, Any] = current_app._get_spec("json")  # type: ignore[attr-defined]  # APIFlask keeps it
    return document


def _groups(document: dict[str, Any]) -> list[dict[str, Any]]:
    """The operations under their tags, with bodies and answers as rows."""
    groups = [{**tag, "operations": []} for tag in document["tags"]]
    by_name = {group["name"]: group for group in groups}
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            rows = [
                (status, answer.get("description", ""), ", ".join(model for _, model in _models(answer)))
                for status, answer in operation["responses"].items()
            ]
            one = {**operation, "method": method.upper(), "path": path, "answers": rows}
            one["body"] = _models(operation.get("requestBody", {}))
            by_name[operation["tags"][0]]["operations"].append(one)
    return groups


def _models(part: dict[str, Any]) -> list[tuple[str, str]]:
    """(media type, model's name or media type) of a body or an answer; of a file its own type alone."""
    content = part.get("content", {})
    return [
        (media_type, declared.get("schema", {}).get("$ref", media_type).rsplit("schemas/", 1)[-1])
        for media_type, declared in content.items()
        if media_type != BINARY or len(content) == 1
    ]


def _fields(schema: dict[str, Any]) -> dict[str, Any]:
    shapes = {name: {**shape, "kind": _kind(shape)} for name, shape in schema.get("properties", {}).items()}
    return {"properties": shapes}


def _kind(shape: dict[str, Any]) -> str:
    """The type of a field in a few words."""
    if "$ref" in shape:
        return str(shape["$ref"]).rsplit("/", 1)[-1]
    if "const" in shape:
        return repr(shape["const"])
    if "enum" in shape:
        return " | ".join(map(str, shape["enum"]))
    for union in ("anyOf", "oneOf"):
        if union in shape:
            return " | ".join(_kind(one) for one in shape[union])
    if shape.get("type") == "array":
        return f"list of {_kind(shape.get('items', {}))}"
    if shape.get("type") == "object" and isinstance(shape.get("additionalProperties"), dict):
        return f"name → {_kind(shape['additionalProperties'])}"
    return str(shape.get("type", "any"))
