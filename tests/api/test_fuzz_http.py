"""Requests made up from our own OpenAPI document, right and wrong ones: never a 500, and every answer as described.

And uploads of what is no torso, or asks for too much: a scan, or one sentence.
"""

import io
import json
from typing import Any

import pytest
import schemathesis
from apiflask import APIFlask
from helpers.bodies import any_body, body
from helpers.damage import bounded, damage, damaged
from helpers.fuzz_table import count
from helpers.gltf_evaluator import GltfScene
from helpers.named_scans import NAMED
from helpers.problems import problem
from helpers.scan_files import ply_text
from helpers.toy_rig import toy_rig
from helpers.waiting import ended
from hypothesis import given
from hypothesis import strategies as st
from schemathesis.checks import not_a_server_error
from schemathesis.generation import GenerationMode
from schemathesis.specs.openapi.checks import content_type_conformance, response_schema_conformance
from werkzeug.datastructures import FileStorage
from werkzeug.test import encode_multipart

from breastrig.api.app import openapi_document
from breastrig.core.glb import pack_glb, split_glb
from breastrig.gltf.mesh_glb import mesh_glb
from breastrig.service.service import Service

pytestmark = pytest.mark.long

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


def glb_of(primitives: int, nodes: int) -> bytes:
    """The toy rig so many times, in few bytes."""
    document, binary = split_glb(mesh_glb(toy_rig().template, toy_rig().faces))
    document["accessors"][document["meshes"][0]["primitives"][0]["indices"]]["count"] = 30
    document["meshes"][0]["primitives"] *= primitives
    document["nodes"] = [{"mesh": 0}] * nodes
    document["scenes"] = [{"nodes": list(range(nodes))}]
    return pack_glb(json.dumps(document).encode(), binary)


@st.composite
def uploads(draw: st.DrawFn) -> tuple[str, bytes]:
    """(kind of upload, file)"""
    kind = draw(st.sampled_from(["body", "body", "far", "many", "named", "damaged"]))
    if kind == "many":
        numbers = st.sampled_from([1, 40, 2001, 30_000])
        return "glb", glb_of(draw(numbers), draw(numbers))
    if kind in ("named", "damaged"):
        name = draw(st.sampled_from(sorted(NAMED)))
        data = NAMED[name]()
        return name.rsplit(".", 1)[-1], damaged(data, draw(damage(len(data)))) if kind == "damaged" else data
    vertices, faces = body(*draw(any_body()))
    place = draw(st.sampled_from([1e2, 1e4, 1e6, 1e8, 1e15, 1e29, 1e300])) if kind == "far" else 0.0
    return "ply", ply_text(vertices + place, faces).replace(b"float", b"double")


@bounded(15)
@given(uploads(), st.sampled_from(["auto", "m", "mm"]))
def test_an_upload_of_anything_is_a_scan_or_one_sentence(app: APIFlask, upload: tuple[str, bytes], units: str) -> None:
    ending, data = upload
    client = app.test_client()
    file = FileStorage(io.BytesIO(data), filename=f"scan.{ending}")
    boundary, body_sent = encode_multipart({"file": file, "units": units})  # the client's own would leave a file open
    answer = client.post("/api/scans", data=body_sent, content_type=f"multipart/form-data; boundary={boundary}")
    count(f"upload of a {ending}", str(answer.status_code))
    if answer.status_code != 201:
        assert answer.status_code in (413, 422)
        assert len(problem(answer, answer.status_code)) < 300
        return
    assert answer.json is not None
    links = answer.json["links"]
    assert GltfScene(client.get(links["mesh"]).data).positions("mesh").shape == (answer.json["vertices"], 3)
    assert client.delete(links["self"]).status_code == 204
