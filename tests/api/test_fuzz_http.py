"""Requests made up from our own OpenAPI document, right and wrong ones: never a 500, and every answer as described."""

import io
from typing import Any

import pytest
import schemathesis
from apiflask import APIFlask
from helpers.damage import bounded
from helpers.fuzz_table import count
from helpers.waiting import ended
from hypothesis import given
from hypothesis import strategies as st
from schemathesis.checks import not_a_server_error
from schemathesis.generation import GenerationMode
from schemathesis.specs.openapi.checks import content_type_conformance, response_schema_conformance

from breastrig.api.app import openapi_document
from breastrig.service.service import Service

EXAMPLES = 16
CHECKS = [not_a_server_error, content_type_conformance]
OWN_SHAPE = ("followFit", "getResult")  # a stream is described as a string; the stand-in's result is a short one
DOCUMENT = openapi_document()
OPERATIONS = {
    operation["operationId"]: (path, method)
    for path, methods in DOCUMENT["paths"].items()
    for method, operation in methods.items()
}


def can_be_wrong(name: str) -> bool:
    """Whether a request of the operation can break its description: an id is any text."""
    path, method = OPERATIONS[name]
    operation = DOCUMENT["paths"][path][method]
    return "requestBody" in operation or any(one["in"] != "path" for one in operation.get("parameters", ()))


REQUESTS = [(name, "positive") for name in OPERATIONS] + [
    (name, "negative") for name in OPERATIONS if can_be_wrong(name)
]


class ReadWhole:
    """The application, with each answer read to its end and closed, as a server does."""

    def __init__(self, app: APIFlask) -> None:
        self._app = app

    def __call__(self, environ: dict[str, Any], start_response: Any) -> list[bytes]:
        answer = self._app(environ, start_response)
        try:
            return [b"".join(answer)]
        finally:
            if hasattr(answer, "close"):
                answer.close()


@pytest.fixture(scope="module")
def described(app: APIFlask) -> Any:
    return schemathesis.openapi.from_wsgi("/api/openapi.json", app)


@pytest.fixture(scope="module")
def known(app: APIFlask, service: Service, torso: bytes) -> dict[str, Any]:
    """A scan and its finished fit, that some requests ask for."""
    client = app.test_client()
    scan = client.post("/api/scans", data={"file": (io.BytesIO(torso), "torso.ply")}).json
    fit = client.post("/api/fits", json={"scan": scan["id"]}).json
    ended(service, fit["id"])
    return {"scan_id": scan["id"], "fit_id": fit["id"], "iteration": 0}


@pytest.mark.parametrize(("name", "mode"), REQUESTS)
def test_requests_of_every_kind_are_answered_as_described(
    described: Any, app: APIFlask, name: str, mode: str, known: dict[str, Any]
) -> None:
    path, method = OPERATIONS[name]
    operation = described[path][method]
    read_whole = ReadWhole(app)

    @bounded(EXAMPLES)
    @given(st.data())
    def run(source: st.DataObject) -> None:
        case = source.draw(operation.as_strategy(generation_mode=GenerationMode(mode)))
        if method != "delete" and source.draw(st.booleans()):  # what is there, else what is not
            case.path_parameters = {
                **(case.path_parameters or {}),
                **{k: v for k, v in known.items() if f"{{{k}}}" in path},
            }
        response = case.call(app=read_whole, headers={"Accept-Encoding": "identity"})  # in memory nobody unpacks
        count(f"{method.upper():<6} {path}", str(response.status_code))
        case.validate_response(response, checks=CHECKS + [response_schema_conformance] * (name not in OWN_SHAPE))

    run()
