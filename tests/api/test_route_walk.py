"""Every route with every kind of credential, as a table of status codes; `make routes` prints it.

The routes come from the application's own map, so a new one is in the walk before anyone thinks of it.
"""

import io
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import pytest
from apiflask import APIFlask
from flask.testing import FlaskClient
from helpers.image_uploads import IMAGE
from helpers.shares import expire
from helpers.waiting import ended

from breastrig.api.config import Config
from breastrig.api.routes.shares import share_credential
from breastrig.scan.kept_image import write_image
from breastrig.service.service import Service
from breastrig.storage.files import VOLUME

TOKEN = "a-token-of-more-than-sixteen-characters"
CREDENTIALS = (
    "no token", "token", "cookie", "signed out", "share", "closed", "expired", "revoked", "forged", "another's",
    "renamed",
)  # fmt: skip
FULL = ("token", "cookie")
SHARED = "/api/shared/<share_id>"
OPEN = "/api/shared/open"
OPEN_TO_ALL = {  # everything outside of /api: health, the sign-in page, the empty pages and their files
    "/", "/healthz", "/metrics", "/readyz", "/s", "/s/<share_id>", "/s/share.js", "/sign-in", "/sign-in/callback",
    "/sign-in/start", "/sign-in/style.css", "/sign-out",
}  # fmt: skip
SHOW_NOBODY = {  # the page and its description, the model: what browsers may keep
    "/", "/s/share.js", "/sign-in/style.css", "/api/docs", "/api/docs/style.css", "/api/openapi.json",
    "/api/scan_protocol.pdf", "/api/models/torso.glb", "/api/models/torso.json", "/api/models/<sha256>/torso.bin",
    "/api/models/<sha256>/torso.glb", "/api/models/<sha256>/torso.json", "/api/models/<sha256>/drawings/<name>.bin",
}  # fmt: skip
NOT_SHOWN = ("mesh.glb", "report.pdf", "report.png", "distances.bin")  # of a share without the scan
Call = tuple[str, str]  # method, pattern of the route
Walk = dict[Call, int]


@dataclass(frozen=True)
class Patient:
    """A scan with a fit that is done, and a share of it."""

    patient: str
    scan: str
    fit: str
    share: dict[str, Any]
    model: str

    def address(self, rule: str) -> str:
        ids = {"scan_id": self.scan, "fit_id": self.fit, "share_id": self.share["id"], "patient_id": self.patient}
        name = "lumpectomy" if "/drawings/" in rule else "standing"
        ids |= {
            "deleted_id": self.patient,
            "version": "1",
            "iteration": "0",
            "name": name,
            "kind": "pp",
            "sha256": self.model,
        }
        return re.sub(r"<(?:\w+:)?(\w+)>", lambda found: ids[found[1]], rule)


@pytest.fixture
def patient(client: FlaskClient, service: Service, torso: bytes) -> Iterator[Callable[[], Patient]]:
    """Makes patients; what is left of them is deleted at the end."""
    scans: list[str] = []
    model = client.get("/api/meta").json["model"]["sha256"]

    def make() -> Patient:
        uploaded = client.post("/api/scans", data={"file": (io.BytesIO(torso), "torso.ply")}).json
        scan, woman = uploaded["id"], uploaded["patient"]
        scans.append(scan)
        write_image(IMAGE, service.storage.files.scan(scan) / VOLUME)
        fit = client.post("/api/fits", json={"scan": scan, "drawing": "lumpectomy"}).json["id"]
        assert ended(service, fit).state == "done"
        return Patient(woman, scan, fit, client.post(f"/api/fits/{fit}/shares", json={}).json, model)

    yield make
    for scan in scans:
        client.delete(f"/api/scans/{scan}")


def secret(share: dict[str, Any]) -> str:
    return str(share["url"]).removeprefix("/s#")


def credential_of(visitor: FlaskClient, share: dict[str, Any]) -> str:
    """What the browser was given when it opened the share."""
    cookie = visitor.get_cookie(
        share_credential.cookie_name(share["id"]), path=share_credential.cookie_path(share["id"])
    )
    assert cookie is not None
    return cookie.value


def give(visitor: FlaskClient, name_of: str, path_of: str, value: str) -> None:
    """A cookie with the name of one share, sent to the addresses of another."""
    visitor.set_cookie(share_credential.cookie_name(name_of), value, path=share_credential.cookie_path(path_of))


def calls_of(app: APIFlask) -> list[Call]:
    """Every route but the files of the page; what ends something at the end, and signing out after it."""
    calls = {
        (method, rule.rule)
        for rule in app.url_map.iter_rules()
        for method in (rule.methods or set()) - {"HEAD", "OPTIONS"}
        if rule.endpoint != "page.asset"
    }
    assert len(calls) > 50
    return sorted(
        calls,
        key=lambda call: (
            call[1] == "/sign-out",
            call[0] == "DELETE" and 100 - call[1].count("/"),  # of a scan's parts first
            call[1] == OPEN,  # ends the visit that the browser had before
            call[1].endswith("/close"),
            call[1].split("/"),
            call[0] != "PUT",
            call[0],
        ),
    )


def body(call: Call, patient: Patient) -> dict[str, Any]:
    """What a well-meant request of that call sends."""
    landmarks = {"landmarks": {"nipple_L": [70, 350, 120]}}
    bodies: dict[Call, dict[str, Any]] = {
        ("PUT", "/api/scans/<scan_id>/landmarks"): {"json": landmarks},
        ("POST", "/api/scans/<scan_id>/landmarks/file"): {
            "data": {"file": (io.BytesIO(b"nipple_L,70,350,120"), "picks.csv")}
        },
        ("POST", "/api/scans/<scan_id>/landmarks/file/<kind>"): {"json": landmarks},
        ("PUT", "/api/scans/<scan_id>/visit"): {"json": {"date": "2026-03-01"}},
        ("PUT", "/api/scans/<scan_id>/cuts"): {"json": {"cuts": []}},
        ("PUT", "/api/scans/<scan_id>/drawing"): {"json": {"shapes": []}},
        ("PUT", "/api/scans/<scan_id>/patient"): {"json": {"patient": patient.patient}},
        ("PATCH", "/api/patients/<patient_id>"): {"json": {"code": "A 7"}},
        ("PUT", "/api/patients/<patient_id>/plan"): {
            "json": {"items": []},
            "headers": {"If-Match": '"0"'},
        },
        ("POST", "/api/fits"): {"json": {"scan": patient.scan}},
        ("POST", "/api/fits/<fit_id>/shares"): {"json": {}},
        ("POST", OPEN): {"json": {"token": secret(patient.share)}},
    }
    return bodies.get(call, {})


def walk(visitor: FlaskClient, calls: list[Call], patient: Patient, headers: dict[str, str]) -> Walk:
    kept = {cookie.key: cookie for cookie in visitor._cookies.values()}
    found = {}
    for call in calls:
        sent = body(call, patient)
        sent["headers"] = headers | sent.get("headers", {})
        answer = visitor.open(patient.address(call[1]), method=call[0], **sent)
        found[call] = answer.status_code
        if answer.headers["Cache-Control"] != "no-store":  # nothing that shows a patient outlives her deletion
            assert call[1] in SHOW_NOBODY, (call, answer.headers["Cache-Control"])
        if answer.status_code == 204 and call[1] in ("/api/scans/<scan_id>", "/api/patients/<patient_id>"):
            assert answer.headers["Clear-Site-Data"] == '"cache"'
        visitor._cookies.clear()  # no call may change who asks the next one
        for cookie in kept.values():
            visitor._cookies[cookie._storage_key] = cookie
    return found


@pytest.mark.slow
def test_every_route_with_every_credential(
    app: APIFlask,
    client: FlaskClient,
    client_for: Callable[[Config], FlaskClient],
    config: Config,
    service: Service,
    patient: Callable[[], Patient],
    keep_route_table: Callable[[list[str]], None],
) -> None:
    calls = calls_of(app)
    mine, others = patient(), patient()
    walks: dict[str, Walk] = {}
    for credential in CREDENTIALS:
        visitor = client_for(replace(config, host="0.0.0.0", token=TOKEN))
        share = others.share if credential in ("another's", "renamed") else mine.share
        if credential in ("expired", "revoked"):
            share = client.post(f"/api/fits/{mine.fit}/shares", json={}).json
        if credential in ("share", "closed", "expired", "revoked", "another's", "renamed"):
            assert visitor.post(OPEN, json={"token": secret(share)}).status_code == 200
        if credential in ("closed", "another's", "renamed"):
            value = credential_of(visitor, share)
        if credential == "closed":
            assert visitor.post(f"/api/shared/{share['id']}/close").status_code == 204
        if credential in ("cookie", "signed out"):
            assert visitor.post("/sign-in", data={"token": TOKEN}).status_code == 303
        if credential == "signed out":
            copied = dict(visitor._cookies)
            visitor.post("/sign-out")
            visitor._cookies.update(copied)
        if credential == "expired":
            expire(service, share["id"])
        if credential == "revoked":
            client.delete(share["links"]["self"])
        if credential == "forged":
            give(visitor, share["id"], mine.share["id"], f"{secret(share)}")
        if credential == "another's":  # as it is, at addresses that a browser would not send it to
            give(visitor, share["id"], mine.share["id"], value)
            assert visitor.get(f"/api/shared/{others.share['id']}/result.json").status_code == 200
        if credential == "renamed":
            give(visitor, mine.share["id"], mine.share["id"], value)
        if credential == "closed":
            give(visitor, share["id"], share["id"], value)
        headers = {"Authorization": f"Bearer {TOKEN}"} if credential == "token" else {}
        whose = patient() if credential in FULL else mine
        if credential in ("expired", "revoked"):
            whose = replace(whose, share=share)
        walks[credential] = walk(visitor, calls, whose, headers)
        if credential in FULL:
            assert client.get(f"/api/scans/{whose.scan}").status_code == 404  # the walk deletes at its end
    assert client.get(f"/api/fits/{mine.fit}").json["state"] == "done"  # nobody else changed or deleted anything
    for share in (mine.share, others.share):
        assert client.get(share["links"]["self"]).json["is_open"]
    assert client.get(f"/api/scans/{mine.scan}/landmarks").json["landmarks"] == {}
    keep_route_table(table(calls, walks))
    for credential, found in walks.items():
        for call, status in found.items():
            assert status in expected(credential, call), (credential, call, status)


REFUSED = (
    "report.pdf",
    "template.pdf",
    "guide.stl",
    "dicom.zip",
    "report.png",
    "measures.csv",
    "measures.json",
    "volume.vtu",
    "/ink",
    "/visits.svg",
    "/change.png",
    "/change.glb",
)  # a fake fit


def expected(credential: str, call: Call) -> set[int]:
    """The statuses that a call may have with a credential."""
    method, rule = call
    if not rule.startswith("/api/"):
        assert rule in OPEN_TO_ALL, rule
        return {200, 303, 401} if rule == "/sign-in" else {200, 303}
    if rule == OPEN:
        return {410} if credential in ("expired", "revoked") else {200}
    if rule == SHARED or rule.startswith(f"{SHARED}/"):
        if rule.endswith("/close"):
            return {204} if credential in ("share", "expired", "revoked") else {401}
        opened = {403} if rule.endswith(NOT_SHOWN) else {200}
        return {"share": opened, "expired": {410}, "revoked": {410}}.get(credential, {401})
    if credential not in FULL:
        return {401}
    if method == "DELETE":
        return {200} if rule.endswith("/length") else {204}
    if rule == "/api/session":
        return {204}
    if method != "GET":
        return (
            {200, 201, 202}
            if rule.endswith(("/unlock", "/refresh")) or body(call, Patient("", "", "", {"url": ""}, ""))
            else {201, 409, 415, 422}
        )
    if rule.endswith("/certificate.pdf"):
        return {404}  # of a patient who is there
    return {422} if rule.endswith(REFUSED) else {200}


def table(calls: list[Call], walks: dict[str, Walk]) -> list[str]:
    width = max(len(rule) for _, rule in calls) + 8
    lines = [f"{'':<{width}}" + "".join(f"{credential:>12}" for credential in walks)]
    for method, rule in sorted(calls, key=lambda call: (call[1].split("/"), call[0] != "PUT", call[0])):
        lines.append(
            f"{method:<7} {rule:<{width - 8}}" + "".join(f"{found[method, rule]:>12}" for found in walks.values())
        )
    return lines
