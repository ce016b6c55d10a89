"""Share links: what they show, what they do not, and when they end."""

import re
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import pytest
from flask.testing import FlaskClient
from helpers.on_disk import bytes_below
from helpers.problems import problem
from helpers.shares import expire
from limits import RateLimitItemPerMinute

from breastrig.api import rate_limits, share_credential
from breastrig.api.config import Config
from breastrig.core.glb import split_glb
from breastrig.jobs.service import Service

TOKEN = "a-token-of-more-than-sixteen-characters"
FILES = ("result.json", "fitted.glb", "fitted.ply", "drawing.json", "distances.bin")


@pytest.fixture
def visitor(client_for: Callable[[Config], FlaskClient], config: Config) -> FlaskClient:
    """A browser that has no token; the service has one."""
    return client_for(replace(config, host="0.0.0.0", token=TOKEN))


@pytest.fixture
def share(client: FlaskClient, fit_id: str) -> Callable[..., dict]:
    """Makes a share of the done fit; the answer with the secret as `token`."""

    def make(**wishes: object) -> dict:
        answer = client.post(f"/api/fits/{fit_id}/shares", json=wishes)
        assert answer.status_code == 201, answer.json
        assert answer.headers["Location"] == answer.json["links"]["self"]
        return answer.json | {"token": answer.json["url"].removeprefix("/s#")}

    return make


def opened(visitor: FlaskClient, made: dict, **more: str):
    return visitor.post("/api/shared/open", json={"token": made["token"], **more})


def test_a_link_shows_the_result_and_by_default_not_the_scan(
    client: FlaskClient, visitor: FlaskClient, service: Service, fit_id: str, share
) -> None:
    made = share()
    assert len(made["token"]) == 32
    left = datetime.fromisoformat(made["expires_at"]) - datetime.now(UTC)
    assert timedelta(days=6.99) < left < timedelta(days=7)
    answer = opened(visitor, made)
    assert answer.status_code == 200
    assert answer.json == {
        "expires_at": made["expires_at"],
        "links": {
            "result": "/api/shared/result.json",
            "fitted_glb": "/api/shared/fitted.glb",
            "fitted_ply": "/api/shared/fitted.ply",
            "drawing": "/api/shared/drawing.json",
            "distances": "/api/shared/distances.bin",
            "report": None,
            "mesh": None,
        },
    }
    assert visitor.get("/api/shared").json == answer.json
    for name in FILES:
        found = visitor.get(f"/api/shared/{name}")
        assert found.data == (service.storage.folders.fit(fit_id) / name).read_bytes()
        assert found.headers["Cache-Control"] == "no-store"
    for name in ("mesh.glb", "report.pdf"):
        assert "does not show the scan" in problem(visitor.get(f"/api/shared/{name}"), 403)


@pytest.mark.parametrize("scan", ["plain", "full"])
def test_the_scan_is_shown_when_the_owner_says_so(
    client: FlaskClient, visitor: FlaskClient, service: Service, scan_id: str, fit_id: str, share, scan: str
) -> None:
    links = opened(visitor, share(scan=scan)).json["links"]
    assert (links["mesh"], links["report"]) == ("/api/shared/mesh.glb", "/api/shared/report.pdf")
    (service.storage.folders.fit(fit_id) / "report.pdf").write_bytes(b"%PDF as it was kept")
    report = visitor.get(links["report"])
    assert (report.data, report.mimetype, report.headers["Cache-Control"]) == (
        b"%PDF as it was kept",
        "application/pdf",
        "no-store",
    )
    answer = visitor.get("/api/shared/mesh.glb")
    assert answer.headers["Cache-Control"] == "no-store"
    whole = client.get(f"/api/scans/{scan_id}/mesh.glb").data
    if scan == "full":
        assert answer.data == whole
    else:
        attributes = split_glb(answer.data)[0]["meshes"][0]["primitives"][0]["attributes"]
        assert set(attributes) == {"POSITION", "NORMAL"}


def test_the_cookie_goes_to_the_shared_calls_only_and_scripts_cannot_read_it(visitor: FlaskClient, share) -> None:
    cookie = opened(visitor, share(expires_in_days=1)).headers["Set-Cookie"]
    for word in ("HttpOnly", "SameSite=Strict", "Path=/api/shared", "Max-Age=43200"):
        assert word in cookie


def test_one_share_opens_no_other_fit(client: FlaskClient, visitor: FlaskClient, service: Service, share) -> None:
    made = share()
    assert opened(visitor, made).status_code == 200
    for name in FILES:
        for attempt in (f"/api/shared/{name}?fit=nobody", f"/api/shared/../{name}", f"/api/shared/nobody/{name}"):
            answer = visitor.get(attempt)
            assert answer.status_code in (200, 401, 404)
            if answer.status_code == 200:
                assert answer.data == visitor.get(f"/api/shared/{name}").data


def test_an_ended_link_opens_nothing_and_says_why(
    client: FlaskClient, visitor: FlaskClient, service: Service, share
) -> None:
    revoked, expired = share(), share()
    for _ in range(2):
        assert client.delete(revoked["links"]["self"]).status_code == 204
    expire(service, expired["id"])
    for made in (revoked, expired):
        assert "expired or was revoked" in problem(opened(visitor, made), 410)
        assert client.get(made["links"]["self"]).json["is_open"] is False
    assert client.get(revoked["links"]["self"]).json["revoked_at"] is not None
    for token in ("x", "x" * 100, revoked["id"], "é"):
        assert "opens nothing" in problem(visitor.post("/api/shared/open", json={"token": token}), 404)


def test_a_passcode_is_asked_for_and_cannot_be_got_round(client: FlaskClient, visitor: FlaskClient, share) -> None:
    made = share(passcode="4711 please")
    assert made["has_passcode"]
    assert "needs a passcode" in problem(opened(visitor, made), 403)
    assert "not the link's passcode" in problem(opened(visitor, made, passcode="4711"), 403)
    visitor.set_cookie(share_credential.COOKIE, f"{made['token']}.", path=share_credential.PATH)
    problem(visitor.get("/api/shared"), 401)
    assert client.get(made["links"]["self"]).json["openings"] == 0
    assert opened(visitor, made, passcode="4711 please").status_code == 200
    assert visitor.get("/api/shared/result.json").status_code == 200


def test_guessing_is_slowed_down(visitor: FlaskClient, share, monkeypatch: pytest.MonkeyPatch) -> None:
    made = share(passcode="4711")
    codes = [
        visitor.post(
            "/api/shared/open",
            json={"token": made["token"], "passcode": f"{guess:04}"},
            environ_base={"REMOTE_ADDR": f"10.0.0.{guess}"},
        ).status_code
        for guess in range(rate_limits.PER_MINUTE["passcode"].amount + 1)
    ]
    assert codes == [403] * (len(codes) - 1) + [429]
    monkeypatch.setitem(rate_limits.PER_MINUTE, "share", RateLimitItemPerMinute(3))
    codes = [visitor.post("/api/shared/open", json={"token": "x"}).status_code for _ in range(4)]
    assert codes == [404, 404, 404, 429]


def test_the_owner_sees_when_a_link_was_opened_and_nothing_about_whom(
    client: FlaskClient, visitor: FlaskClient, fit_id: str, share
) -> None:
    made = share()
    for _ in range(3):
        opened(visitor, made)
    seen = client.get(made["links"]["self"]).json
    assert seen["openings"] == len(seen["opened_at"]) == 3
    assert seen["last_opened_at"] == seen["opened_at"][0] == max(seen["opened_at"])
    assert "url" not in seen
    assert set(seen) == {
        *("id", "created_at", "expires_at", "revoked_at", "is_open", "scan", "has_passcode"),
        *("openings", "last_opened_at", "opened_at", "links"),
    }


def test_shares_are_listed_page_by_page(client: FlaskClient, fit_id: str, share) -> None:
    made = [share()["id"] for _ in range(3)]
    address = client.get(f"/api/fits/{fit_id}").json["links"]["shares"]
    assert [one["id"] for one in client.get(address).json["shares"]] == made[::-1]
    found, address = [], f"{address}?limit=2"
    while address:
        page = client.get(address).json
        found += [one["id"] for one in page["shares"]]
        address = page["next"]
    assert found == made[::-1]


def test_only_hashes_of_secrets_are_stored_and_delete_removes_them(
    client: FlaskClient, visitor: FlaskClient, service: Service, scan_id: str, share
) -> None:
    made = share(passcode="xylophone-17")
    opened(visitor, made, passcode="xylophone-17")
    kept = bytes_below(service.storage.root)
    assert made["token"].encode() not in kept
    assert b"xylophone" not in kept
    assert made["id"].encode() in kept
    client.delete(f"/api/scans/{scan_id}")
    left = bytes_below(service.storage.root)
    assert made["id"].encode() not in left
    assert share_credential.token_sha256(made["token"]).encode() not in left
    problem(visitor.get("/api/shared/result.json"), 404)


@pytest.mark.parametrize(
    "wishes",
    [{"expires_in_days": 0}, {"expires_in_days": 91}, {"passcode": "123"}, {"scan": "some"}, {"fit": "other"}],
)
def test_a_share_that_cannot_be_meant_is_refused(client: FlaskClient, fit_id: str, wishes: dict) -> None:
    problem(client.post(f"/api/fits/{fit_id}/shares", json=wishes), 422)


def test_only_results_are_shared(client: FlaskClient, scan_id: str) -> None:
    problem(client.post("/api/fits/nobody/shares", json={}), 404)
    problem(client.get("/api/fits/nobody/shares"), 404)
    problem(client.get("/api/fits/nobody/shares/nobody"), 404)
    assert client.delete("/api/fits/nobody/shares/nobody").status_code == 204
    running = client.post("/api/fits", json={"scan": scan_id, "preset": "paper", "drawing": None}).json
    assert "no result to share" in problem(client.post(running["links"]["shares"], json={}), 409)
    client.post(running["links"]["cancel"])


def test_the_page_of_a_link_holds_nothing_by_itself(visitor: FlaskClient) -> None:
    answer = visitor.get("/s")
    assert (answer.status_code, answer.headers["Cache-Control"]) == (200, "no-store")
    html = answer.get_data(as_text=True)
    assert "<script>" not in html
    assert 'style="' not in html
    for place in re.findall(r'(?:src|href)="([^"]+)"', html):
        assert place.startswith("/")
        assert visitor.get(place).status_code == 200
    assert visitor.get("/s/share.js").mimetype == "text/javascript"
    assert answer.headers["Referrer-Policy"] == "no-referrer"
