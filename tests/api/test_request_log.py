"""The log of requests: what it says of each, and that it says nothing of anybody."""

import logging
from collections.abc import Callable
from dataclasses import replace

import pytest
from flask.testing import FlaskClient

from breastrig.api.config import Config
from breastrig.core.log_lines import FIELDS

SECRET = "eine-geheime-Nummer"


@pytest.fixture
def logged(client_for: Callable[[Config], FlaskClient], config: Config) -> FlaskClient:
    return client_for(replace(config, log_requests=True))


def logged_fields(caplog: pytest.LogCaptureFixture) -> list[dict[str, object]]:
    return [getattr(one, FIELDS) for one in caplog.records if one.name == "breastrig.requests"]


def test_each_answer_is_logged_by_method_route_status_and_time(
    logged: FlaskClient, fit_id: str, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    logged.get(f"/api/fits/{fit_id}?with={SECRET}", headers={"X-Anything": SECRET})
    logged.get(f"/api/scans/{SECRET}")
    logged.patch(f"/api/patients/{SECRET}", json={"code": "x"})
    logged.open(f"/{SECRET}", method="BREW")
    logged.get("/api/meta", headers={"Host": "evil.example"})
    lines = logged_fields(caplog)
    assert [(line["method"], line["route"], line["status"]) for line in lines] == [
        ("GET", "/api/fits/<fit_id>", 200),
        ("GET", "/api/scans/<scan_id>", 404),
        ("PATCH", "/api/patients/<patient_id>", 404),
        ("other", "none", 405),
        ("GET", "/api/meta", 421),
    ]
    assert all(set(line) == {"method", "route", "status", "duration_ms"} for line in lines)
    assert all(0.0 <= float(str(line["duration_ms"])) < 60_000.0 for line in lines)
    for word in (SECRET, fit_id, "127.0.0.1", "evil"):
        assert word not in caplog.text


def test_a_stream_is_logged_when_it_ends(logged: FlaskClient, fit_id: str, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)
    answer = logged.get(f"/api/fits/{fit_id}/events", buffered=False)
    assert logged_fields(caplog) == []
    answer.close()
    [line] = logged_fields(caplog)
    assert line["route"] == "/api/fits/<fit_id>/events"


def test_nothing_is_logged_unless_asked_for(client: FlaskClient, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)
    assert client.get("/healthz").status_code == 200
    assert logged_fields(caplog) == []
