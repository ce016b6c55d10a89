"""Turns APIFlask's document into the one that is published.

* nested models keep their own name (APIFlask calls them Outer.Inner, one copy for each use),
* a field that may be left out is optional, not "null by default",
* every error is a problem-details answer,
* results are described as the service sends them.
"""

import json
import re
from typing import Any

from breastrig.api.access.session import COOKIE
from breastrig.api.wire import common as wire
from breastrig.core.notice import LIMITS_OF_USE

SESSION = "set by the page /sign-in and by /?token=...; its name ends with _PORT where the address has a port"
REFERENCE = "#/components/schemas/"
LONG_NAME = re.compile(rf'"{REFERENCE}[^"]*\.([^".]+)"')
ERROR_STATUS = range(400, 600)


def finish_document(document: dict[str, Any]) -> dict[str, Any]:
    """The published document."""
    document = json.loads(LONG_NAME.sub(rf'"{REFERENCE}\1"', json.dumps(document)))
    schemas = _named_once(document["components"]["schemas"])
    for unwanted in ("HTTPError", "ValidationError"):
        schemas.pop(unwanted, None)
    schemas["Problem"] = wire.Problem.model_json_schema(ref_template=REFERENCE + "{model}")
    schemas.update(schemas["Problem"].pop("$defs", {}))
    for part in (*schemas.values(), document["paths"]):
        _drop_null_defaults(part)
    for methods in document["paths"].values():
        for operation in methods.values():
            _describe_errors(operation)
            if "requestBody" in operation:
                operation["requestBody"]["required"] = True
    document["components"]["securitySchemes"] = {
        "token": {"type": "http", "scheme": "bearer"},
        "session": {"type": "apiKey", "in": "cookie", "name": COOKIE, "description": SESSION},
    }
    document["security"] = [{}, {"token": []}, {"session": []}]
    document["info"]["description"] = LIMITS_OF_USE
    document["tags"] = list({tag["name"]: tag for tag in document["tags"]}.values())  # two blueprints may share one
    document["components"]["schemas"] = dict(sorted(schemas.items()))
    document["paths"] = dict(sorted(document["paths"].items()))
    return {"openapi": document.pop("openapi"), **document}


def openapi_bytes(document: dict[str, Any]) -> bytes:
    """The document as it is sent and committed."""
    return (json.dumps(document, indent=1, ensure_ascii=False) + "\n").encode()


def _named_once(schemas: dict[str, Any]) -> dict[str, Any]:
    """Outer.Inner becomes Inner.  Raises when two different models share a name."""
    result: dict[str, Any] = {}
    for name, schema in schemas.items():
        short = name.rsplit(".", 1)[-1]
        if result.setdefault(short, schema) != schema:
            raise ValueError(f"two different models are called {short}")
    return result


def _drop_null_defaults(node: Any) -> None:
    if isinstance(node, dict):
        if "default" in node and node["default"] is None:
            del node["default"]
        for value in node.values():
            _drop_null_defaults(value)
    elif isinstance(node, list):
        for value in node:
            _drop_null_defaults(value)


def _describe_errors(operation: dict[str, Any]) -> None:
    content = {"application/problem+json": {"schema": {"$ref": REFERENCE + "Problem"}}}
    for status, answer in operation["responses"].items():
        if int(status) in ERROR_STATUS:
            answer["content"] = content
    operation["responses"]["default"] = {"description": "Any other error", "content": content}
