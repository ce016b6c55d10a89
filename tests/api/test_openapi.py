import json
import re

import pytest
from apiflask import APIFlask
from flask.testing import FlaskClient

from breastrig.api.app import openapi_document
from breastrig.api.openapi import openapi_bytes
from breastrig.api.write_openapi import FILE


def test_the_committed_document_is_fresh() -> None:
    fresh = FILE.read_bytes() == openapi_bytes(openapi_document())
    assert fresh, "run: python -m breastrig.api.write_openapi, then: npm --prefix web run types"


def test_the_served_document_is_the_committed_one(client: FlaskClient) -> None:
    answer = client.get("/api/openapi.json")
    assert answer.data == FILE.read_bytes()
    assert answer.json["openapi"].startswith("3.1")


def test_every_route_of_the_api_is_described_once(app: APIFlask) -> None:
    document = openapi_document()
    described = {(path, method.upper()) for path, methods in document["paths"].items() for method in methods}
    routes = {
        (re.sub(r"<(?:\w+:)?(\w+)>", r"{\1}", rule.rule), method)
        for rule in app.url_map.iter_rules()
        if not rule.endpoint.startswith(("docs.", "page.", "sign_in.", "share_page.", "audit.show_page"))
        for method in (rule.methods or set()) - {"HEAD", "OPTIONS"}
    }
    assert described == routes
    names = [operation["operationId"] for methods in document["paths"].values() for operation in methods.values()]
    assert len(names) == len(set(names))


@pytest.mark.slow
def test_every_reference_of_the_document_leads_somewhere() -> None:
    text = json.dumps(openapi_document())
    names = set(re.findall(r'"#/components/schemas/([^"]+)"', text))
    assert names <= set(openapi_document()["components"]["schemas"])
    assert not any("." in name for name in openapi_document()["components"]["schemas"])


def test_the_docs_page_lists_every_operation_and_loads_nothing_from_elsewhere(client: FlaskClient) -> None:
    answer = client.get("/api/docs")
    assert (answer.status_code, answer.mimetype) == (200, "text/html")
    html = answer.get_data(as_text=True)
    for path in openapi_document()["paths"]:
        assert path in html
    assert "<script" not in html
    assert "//" not in re.sub(r"<!--.*?-->", "", html)
    assert 'style="' not in html
    assert "application/octet-stream" in html
    assert ", application/octet-stream" not in html  # of a file with a type of its own
    assert client.get("/api/docs/style.css").mimetype == "text/css"
