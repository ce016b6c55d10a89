import json
import logging
import re
from dataclasses import replace
from pathlib import Path

import pytest
from apiflask import APIFlask
from flask.testing import FlaskClient
from helpers.problems import problem
from limits import RateLimitItemPerMinute

from breastrig.api.access.rate_limits import PER_MINUTE
from breastrig.api.access.security import HEADERS
from breastrig.api.config import Config, checked_token, is_loopback
from breastrig.core.errors import BadSettings
from breastrig.core.log_lines import TEXT, JsonLines, TextLines
from breastrig.execution.limits import UploadLimits

TOKEN = "a-token-of-more-than-sixteen-characters"


def every_call(app: APIFlask) -> list[tuple[str, str]]:
    """(method, address) of every route, ids filled in with nobody's."""
    return [
        (method, re.sub(r"<(?:(\w+):)?(\w+)>", lambda m: "0" if m[1] == "int" else "nobody", rule.rule))
        for rule in app.url_map.iter_rules()
        for method in sorted((rule.methods or set()) - {"HEAD"})
    ]


@pytest.mark.slow
def test_every_route_answers_with_the_security_headers(app: APIFlask, client: FlaskClient) -> None:
    calls = every_call(app)
    assert len(calls) > 40
    for method, address in calls:
        answer = client.open(address, method=method)
        form = {"Referrer-Policy": "same-origin"} if address == "/sign-in" and method == "GET" else {}
        for name, value in (HEADERS | form).items():
            assert answer.headers.get(name) == value, (method, address)
        assert "Cache-Control" in answer.headers, (method, address)
        assert answer.status_code < 500, (method, address)
        if answer.status_code >= 400:
            problem(answer, answer.status_code)
        answer.close()


def test_what_shows_a_patient_is_not_kept_by_the_browser(client: FlaskClient, scan_id: str, fit_id: str) -> None:
    for place in (f"scans/{scan_id}", f"scans/{scan_id}/landmarks", f"fits/{fit_id}", f"fits/{fit_id}/events.json"):
        assert client.get(f"/api/{place}").headers["Cache-Control"] == "no-store"


def test_the_policy_lets_nothing_in_from_elsewhere() -> None:
    policy = dict(part.split(" ", 1) for part in HEADERS["Content-Security-Policy"].split("; "))
    assert policy["default-src"] == "'self'"
    assert policy["object-src"] == policy["frame-ancestors"] == "'none'"
    assert "unsafe" not in HEADERS["Content-Security-Policy"]
    assert "http" not in HEADERS["Content-Security-Policy"]


@pytest.mark.parametrize("host", ["localhost", "localhost:8321", "127.0.0.1:1", "[::1]:8321", "LOCALHOST"])
def test_the_own_names_are_answered(client: FlaskClient, host: str) -> None:
    assert client.get("/healthz", headers={"Host": host}).status_code == 200


@pytest.mark.parametrize("host", ["evil.example", "localhost.evil.example", "127.0.0.1.evil.example", "", "[::1", "0"])
def test_a_foreign_name_is_refused_as_dns_rebinding(client: FlaskClient, host: str) -> None:
    assert "own name" in problem(client.get("/api/meta", headers={"Host": host}), 421)


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Origin": "http://localhost:9999"},
        {"Origin": "file://localhost"},
        {"Origin": "http://[::1"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
    ],
)
def test_another_page_cannot_change_anything(client: FlaskClient, scan_id: str, headers: dict[str, str]) -> None:
    assert "another web page" in problem(client.delete(f"/api/scans/{scan_id}", headers=headers), 403)
    assert client.get(f"/api/scans/{scan_id}").status_code == 200


def test_the_own_page_and_programs_can(client: FlaskClient) -> None:
    for headers in (
        {"Origin": "http://localhost"},
        {"Origin": "http://LocalHost"},
        {"Sec-Fetch-Site": "same-origin"},
        {},
    ):
        assert client.delete("/api/scans/nobody", headers=headers).status_code == 204


def test_a_body_of_another_type_is_refused(client: FlaskClient, scan_id: str) -> None:
    body = json.dumps({"scan": scan_id})
    for content_type in ("text/plain", "application/x-www-form-urlencoded", None):
        answer = client.post("/api/fits", data=body, content_type=content_type)
        assert "application/json" in problem(answer, 415)
    assert "multipart/form-data" in problem(client.post("/api/scans", json={}), 415)


@pytest.mark.parametrize("body", [b"", b"{", b"\xff\xfe", b'{"scan": "a" "b"}', b"[" * 100_000, b"9" * 5000])
def test_a_body_that_is_not_json_is_refused(client: FlaskClient, body: bytes) -> None:
    answer = client.post("/api/fits", data=body, content_type="application/json")
    assert answer.status_code in (400, 422)
    problem(answer, answer.status_code)


def test_a_strange_string_is_refused(client: FlaskClient) -> None:
    for text in (r'{"scan": "\ud800"}', r'{"scan": "\u0000"}', '{"scan": "' + "x" * 101 + '"}'):
        answer = client.post("/api/fits", data=text, content_type="application/json")
        assert answer.status_code in (404, 422)
        problem(answer, answer.status_code)


def test_a_body_that_is_too_large_is_refused(client_for, config: Config) -> None:
    small = client_for(replace(config, uploads=UploadLimits(file_bytes=1_000_000, zip_bytes=2_000_000)))
    answer = small.post("/api/scans", data=bytes(2_100_000), content_type="multipart/form-data; boundary=x")
    assert "larger than 2 MB" in problem(answer, 413)
    answer = small.post("/api/scans/a/lesions", data=bytes(1_100_000), content_type="multipart/form-data; boundary=x")
    assert "larger than 1 MB" in problem(answer, 413)
    answer = small.post("/api/fits", data=bytes(20_000_001), content_type="application/json")
    assert "larger than 20 MB" in problem(answer, 413)
    visitor = small.post("/api/shared/open", data=bytes(10_001), content_type="application/json")
    assert "larger than 10 kB" in problem(visitor, 413)


def test_unknown_addresses_and_methods_say_so(client: FlaskClient) -> None:
    for address in (
        "/api",
        "/api/",
        "/api/nothing",
        "/nothing",
        "/api/scans/",
        "/api/scans//landmarks",
        "/%00",
        "/%ff",
    ):
        assert problem(client.get(address), 404).startswith("There is nothing at this address")
    for method in ("PUT", "PATCH"):
        answer = client.open("/api/fits", method=method)
        assert method in problem(answer, 405)
        assert set(answer.headers["Allow"].split(", ")) == {"GET", "HEAD", "POST", "OPTIONS"}


@pytest.mark.parametrize(
    "address", ["/../pyproject.toml", "/assets/../../x", "/..%2f..%2fetc/passwd", "/%2fetc/passwd"]
)
def test_nothing_outside_of_the_page_is_served(client: FlaskClient, address: str) -> None:
    answer = client.get(address)
    assert answer.status_code in (404, 308)
    answer.close()


def test_an_error_of_ours_shows_no_trace(app: APIFlask, client: FlaskClient, monkeypatch, caplog) -> None:
    monkeypatch.setitem(app.view_functions, "operations.health", lambda: 1 / 0)
    assert problem(client.get("/healthz"), 500) == "Something went wrong inside BreastRig; the server's log says what."
    assert "ZeroDivisionError" in caplog.text


@pytest.fixture
def guarded(client_for, config: Config) -> FlaskClient:
    return client_for(replace(config, host="0.0.0.0", token=TOKEN))


@pytest.mark.slow
def test_with_a_token_every_call_of_the_api_needs_it(app: APIFlask, guarded: FlaskClient) -> None:
    wrong = ({}, {"Authorization": "Bearer wrong"}, {"Authorization": f"Basic {TOKEN}"}, {"Authorization": TOKEN})
    for number, (method, address) in enumerate(every_call(app)):
        if not address.startswith("/api/") or address.startswith("/api/shared"):  # those: test_shares.py
            continue
        asked_from = {"REMOTE_ADDR": f"10.0.0.{number}"}  # one address may not guess so often
        for headers in wrong:
            answer = guarded.open(address, method=method, headers=headers, environ_base=asked_from)
            problem(answer, 401)
            assert answer.headers["WWW-Authenticate"] == "Bearer"
        right = guarded.open(address, method=method, headers={"Authorization": f"Bearer {TOKEN}"})
        assert right.status_code != 401
        right.close()


def test_wrong_tokens_are_counted_for_each_address_and_in_all_and_the_right_one_always_passes(
    guarded: FlaskClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    right, wrong = ({"Authorization": f"Bearer {token}"} for token in (TOKEN, "wrong"))
    monkeypatch.setitem(PER_MINUTE, "bearer", RateLimitItemPerMinute(3))
    monkeypatch.setitem(PER_MINUTE, "bearer of anybody", RateLimitItemPerMinute(8))

    def ask(address: str, headers: dict[str, str], path: str = "/api/meta") -> int:
        answer = guarded.get(path, headers=headers, environ_base={"REMOTE_ADDR": address})
        if answer.status_code == 429:
            assert "Too many" in problem(answer, 429)
            assert 1 <= int(answer.headers["Retry-After"]) <= 60
        return answer.status_code

    assert [ask("10.0.0.1", wrong) for _ in range(4)] == [401, 401, 401, 429]
    assert [ask("10.0.0.1", {}) for _ in range(2)] == [401, 401]  # no guess
    assert ask("10.0.0.1", right) == 200
    assert [ask("10.0.0.2", wrong, "/metrics") for _ in range(4)] == [403, 403, 403, 429]
    assert [ask(f"10.0.1.{number}", wrong) for number in range(4)] == [401, 401, 429, 429]
    assert ask("10.0.0.2", right) == ask("10.0.9.9", right) == 200


@pytest.mark.slow
@pytest.mark.parametrize("length", [130, 8_000])
def test_an_address_that_is_too_long_is_not_there_and_not_in_the_log(
    app: APIFlask, client: FlaskClient, caplog: pytest.LogCaptureFixture, length: int
) -> None:
    caplog.set_level(logging.INFO)
    long = "Miller-Jane-" * (length // 12 + 1)
    asked = [f"/{long}", f"/assets/{long}", f"/a/{long}/b", f"/%2e%2e/{long}"]
    rules = [rule.rule for rule in app.url_map.iter_rules() if rule.arguments]
    asked += [re.sub(r"<(?:(\w+):)?\w+>", lambda m: "0" if m[1] == "int" else long, rule) for rule in rules]
    for address in asked:
        for method in ("GET", "POST", "PUT", "DELETE"):
            answer = client.open(address, method=method)
            assert answer.status_code < 500, (method, address[:50])
    for address in asked[:4]:
        assert problem(client.get(address), 404)
    assert "Miller" not in caplog.text


def test_an_error_of_ours_is_logged_without_the_address_that_met_it(
    app: APIFlask, client: FlaskClient, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    secret = "Jane O'Miller"

    def fail(scan_id: str) -> None:
        raise FileNotFoundError(2, "No such file", f"/data/scans/{scan_id}/mesh.glb")

    monkeypatch.setitem(app.view_functions, "scans.show_mesh", fail)
    answer = client.get(f"/api/scans/{secret}/mesh.glb?who={secret}")
    assert problem(answer, 500).startswith("Something went wrong inside BreastRig")
    [record] = [one for one in caplog.records if one.levelname == "ERROR"]
    for form in (JsonLines(), TextLines(TEXT)):
        line = form.format(record)
        assert "/api/scans/<scan_id>/mesh.glb" in line
        assert "FileNotFoundError" in line
        assert "Traceback" in line
        assert "in fail" in line
        assert "Miller" not in line


def test_with_a_token_health_and_the_pages_files_are_open(guarded: FlaskClient) -> None:
    assert guarded.get("/healthz").status_code == 200
    assert guarded.get("/assets/index-abc123.js").status_code == 200
    assert guarded.get("/healthz", headers={"Host": "scans.hospital.example"}).status_code == 200


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1", "127.8.8.8", "::1", "LocalHost"])
def test_this_machine_needs_no_token(host: str) -> None:
    assert is_loopback(host)
    tokens = {checked_token(host, None) for _ in range(2)}
    assert len(tokens) == 2
    assert all(token is not None and len(token) >= 32 for token in tokens)
    assert checked_token(host, None, no_token=True) is None
    with pytest.raises(BadSettings, match="--no-token says that there is none"):
        checked_token(host, TOKEN, no_token=True)
    assert checked_token(host, TOKEN) == TOKEN


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.1.5", "10.0.0.1", "scans.example", ""])
def test_any_other_address_needs_one(host: str) -> None:
    with pytest.raises(BadSettings, match="BREASTRIG_TOKEN"):
        checked_token(host, None)
    with pytest.raises(BadSettings, match="too short"):
        checked_token(host, "short")
    with pytest.raises(BadSettings, match="would show patients"):
        checked_token(host, None, no_token=True)
    assert checked_token(host, TOKEN) == TOKEN


def test_the_page_is_served_and_its_hashed_files_kept(client: FlaskClient) -> None:
    index = client.get("/")
    assert b"the page" in index.data
    assert index.headers["Cache-Control"] == "no-cache"
    asset = client.get("/assets/index-abc123.js")
    assert asset.headers["Cache-Control"] == "public, max-age=31536000, immutable"
    assert asset.mimetype == "text/javascript"
    assert client.get("/index.html").status_code == 200


def test_a_copy_without_a_page_says_how_to_build_it(client_for, config: Config, tmp_path: Path) -> None:
    answer = client_for(replace(config, web=tmp_path)).get("/")
    assert answer.status_code == 503
    assert b"make serve" in answer.data
    assert b"/api/docs" in answer.data
