"""What requests write into the audit log: who, what, of which ids, and nothing of what they hold."""

import errno
import io
import json
import os
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import pytest
from flask.testing import FlaskClient
from pypdf import PdfReader

from breastrig.api.access import audited, person, security
from breastrig.api.access.person import Person, Role
from breastrig.api.config import Config
from breastrig.api.routes.administration import audit as administration
from breastrig.audit import log as audit_log
from breastrig.audit.log import log_files
from breastrig.audit.read import check, deletions, lines_from
from breastrig.service.service import Service

Lines = Callable[[], list[dict[str, Any]]]


@pytest.fixture
def lines(service: Service) -> Lines:
    """The lines since the beginning of the test, oldest first."""
    service.audit.flush()  # what other tests have opened
    before = service.audit.end().line

    def read() -> list[dict[str, Any]]:
        service.audit.flush()
        return [line for line in lines_from(service.storage.root) if line["n"] > before][::-1]

    return read


def test_a_day_of_a_scan(client: FlaskClient, torso: bytes, lines: Lines) -> None:
    made = client.post("/api/scans", data={"file": (io.BytesIO(torso), "torso.ply")}).json
    scan, patient = made["id"], made["patient"]
    client.patch(f"/api/patients/{patient}", json={"code": "Maria M."})
    client.get(f"/api/scans/{scan}")
    client.get(f"/api/scans/{scan}/landmarks")  # the same opening
    client.put(f"/api/scans/{scan}/landmarks", json={"landmarks": {"nobody": [1, 2, 3]}})
    client.delete(f"/api/scans/{scan}")
    found = lines()
    own = {"patient": patient, "scan": scan}
    assert [(line["what"], line["how"], line.get("of", {})) for line in found] == [
        ("change", "scans.upload_scan", {}),
        ("done", "scans.upload_scan", own),
        ("change", "patients.change_patient", {"patient": patient}),
        ("open", "scans.show_scan", own),
        ("change", "of_scans.replace_landmarks", own),
        ("refused", "of_scans.replace_landmarks", own),
        ("delete", "scans.remove_scan", own),
        ("done", "scans.remove_scan", own),
    ]
    assert found[1]["line"] == found[0]["n"]
    assert (found[5]["line"], found[5]["status"]) == (found[4]["n"], 422)
    assert found[6]["removes"]["case"]
    assert found[7]["left"] == 0
    assert {line["who"] for line in found} == {"token"}
    assert "Maria" not in json.dumps(found)
    assert "nobody" not in json.dumps(found)


def test_fits_links_and_their_visitors(
    client: FlaskClient, client_for: Callable[[Config], FlaskClient], config: Config, fit_id: str, lines: Lines
) -> None:
    share = client.post(f"/api/fits/{fit_id}/shares", json={}).json
    visitor = client_for(replace(config, token="a-token-of-more-than-sixteen-characters"))
    visitor.get(f"/api/fits/{fit_id}")  # refused by the guard: nothing is opened
    visitor.post("/api/shared/open", json={"token": share["url"].removeprefix("/s#")})
    visitor.get(f"/api/shared/{share['id']}/fitted.ply")
    assert visitor.get(f"/api/shared/{share['id']}/report.pdf").status_code == 403
    client.get(f"/api/fits/{fit_id}/result.zip")
    client.get(f"/api/fits/{fit_id}/result.zip")
    client.delete(f"/api/fits/{fit_id}/shares/{share['id']}")
    found = [line for line in lines() if line["how"] != "fits.start_fit"]
    link = f"link:{share['id']}"
    assert [(line["who"], line["what"], line["how"]) for line in found] == [
        ("token", "link", "shares.make_share"),
        ("token", "done", "shares.make_share"),
        (link, "open", "shared.open_share"),
        (link, "export", "shared.show_fitted_ply"),
        (link, "refused", "shared.show_report"),
        ("token", "export", "results.show_result_zip"),
        ("token", "export", "results.show_result_zip"),
        ("token", "link", "shares.remove_share"),
    ]
    assert found[1]["of"] == {"link": share["id"]}
    assert all(line["of"]["fit"] == fit_id for line in found if line["what"] != "done")
    assert all(set(line["of"]) >= {"patient", "scan", "link"} for line in found[2:5])


def test_a_fit_names_its_scan_and_a_person_is_named(
    client: FlaskClient, service: Service, scan_id: str, lines: Lines, monkeypatch: pytest.MonkeyPatch
) -> None:
    anna = Person("a-1", "Anna Arzt", Role.PLAN)
    monkeypatch.setattr(audited, "current_person", lambda: anna)
    fit = client.post("/api/fits", json={"scan": scan_id}).json["id"]
    asked, done = (line for line in lines() if line["how"] == "fits.start_fit")
    assert (asked["who"], asked["name"], asked["of"]["scan"]) == ("person:a-1", "Anna Arzt", scan_id)
    assert (done["of"]["fit"], done["line"]) == (fit, asked["n"])
    client.post(f"/api/fits/{fit}/cancel")
    assert person.current_person() == person.HOLDER


def test_administrators_page_through_it_and_others_see_nothing(
    client: FlaskClient, service: Service, scan_id: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    client.put(f"/api/scans/{scan_id}/landmarks", json={"landmarks": {}})
    page = client.get(f"/api/audit?id={scan_id}&limit=1").json
    [line] = page["lines"]
    assert (line["what"], line["how"], line["ids"]["scan"]) == ("change", "of_scans.replace_landmarks", scan_id)
    older = client.get(page["next"]).json["lines"]
    assert [(each["what"], each["how"]) for each in older] == [("done", "scans.upload_scan")]
    assert client.get("/api/audit?since=2999").json == {"lines": [], "next": None}
    found = client.get("/api/audit/check").json
    assert found["fault"] == ""
    assert client.get(f"/api/audit/check?anchor={found['end']}").json["fault"] == ""
    assert client.get(f"/api/audit/check?anchor=1:{'0' * 64}").json["fault"].startswith("Line 1 is not the one")
    kept = client.get("/api/audit/log.jsonl").data
    assert (
        kept.splitlines()
        == [line for file in log_files(service.audit.folder) for line in file.read_bytes().splitlines()][
            : len(kept.splitlines())
        ]
    )
    page = client.get(f"/api/audit/page?id={scan_id}").text
    assert "All lines are as they were written." in page
    assert f"<code>{scan_id}</code>" in page
    assert "of_scans.replace_landmarks" in page
    german = client.get(f"/api/audit/page?id={scan_id}", headers={"Accept-Language": "de"}).text
    for part in (
        'lang="de"',
        "Alle Zeilen sind, wie sie geschrieben wurden.",
        "<td>Änderung",
        "Kennung eines Patienten",
    ):
        assert part in german, part
    assert not re.search(r"\b(Line|When|Who|newest|Download|change|patient) ", german)
    monkeypatch.setattr(security, "current_person", lambda: Person("a-1", "Anna Arzt", Role.PLAN))
    for place in ("", "/check", "/log.jsonl", "/page"):
        assert client.get(f"/api/audit{place}").status_code == 403


def text_of(pdf: bytes) -> str:
    return " ".join(" ".join(page.extract_text() for page in PdfReader(io.BytesIO(pdf)).pages).split())


def test_a_deletion_is_certified_to_who_deleted_and_to_administrators(
    client: FlaskClient, torso: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = client.post("/api/scans", data={"file": (io.BytesIO(torso), "torso.ply")}).json
    scan, patient = made["id"], made["patient"]
    place = f"/api/audit/deletions/{patient}/certificate.pdf"
    assert client.get(place).status_code == 404
    anna, bert = Person("a-1", "Anna Arzt", Role.PLAN), Person("b-2", "Bert", Role.PLAN)
    monkeypatch.setattr(audited, "current_person", lambda: anna)
    assert client.delete(f"/api/patients/{patient}").status_code == 204
    certificate = client.get(place)
    assert certificate.status_code == 200
    assert certificate.headers["Content-Disposition"] == f"attachment; filename=deletion_{patient}.pdf"
    said = text_of(certificate.data)
    for part in (
        patient,
        scan,
        "Anna Arzt (person:a-1)",
        "scans: 1, fits: 0, links: 0",
        "and what was planned on these scans",
        "are as they were written",
        "Backups",
    ):
        assert part in said, part
    assert client.get(f"/api/audit/deletions/{scan}/certificate.pdf").status_code == 200
    german = text_of(client.get(place, headers={"Accept-Language": "de"}).data)
    for part in (
        "Bescheinigung einer Löschung",
        "Verlangt von Anna Arzt (person:a-1), patients.remove_patient",
        "Scans: 1, Anpassungen: 0, Links: 0, Dateien:",
        "MB), und was auf diesen Scans geplant war",
        "sind, wie sie geschrieben wurden",
    ):
        assert part in german, (part, german)
    assert not re.search(r"\b(verified|cover|place|signature|Removed|Asked|Issued|lines)\b", german)
    monkeypatch.setattr(audited, "current_person", lambda: bert)
    monkeypatch.setattr(administration, "current_person", lambda: bert)
    assert client.get(place).status_code == 403


def test_deleting_who_is_out_of_reach_is_no_deletion(
    client: FlaskClient, service: Service, torso: bytes, lines: Lines, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = client.post("/api/scans", data={"file": (io.BytesIO(torso), "torso.ply")}).json
    with monkeypatch.context() as patch:
        patch.setattr(service.storage, "groups_in_reach", lambda: ("another",))
        client.delete(f"/api/patients/{made['patient']}")
    assert client.get(f"/api/patients/{made['patient']}").status_code == 200
    found = [line for line in lines() if line["how"] == "patients.remove_patient"]
    assert [line["what"] for line in found] == ["delete", "refused"]
    assert not list(deletions(service.storage.root, made["patient"]))
    assert client.get(f"/api/audit/deletions/{made['patient']}/certificate.pdf").status_code == 404
    client.delete(f"/api/patients/{made['patient']}")
    [line] = deletions(service.storage.root, made["patient"])
    assert line["done"]["left"] == 0


@pytest.fixture
def full(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[bool], None]]:
    """A disk that has no room for the audit log alone."""
    write, state = audit_log._appended, [False]

    def appended(*given: Any) -> None:
        if state[0]:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        write(*given)

    monkeypatch.setattr(audit_log, "_appended", appended)
    yield lambda is_full: state.__setitem__(0, is_full)
    state[0] = False


def test_what_cannot_be_written_is_not_changed_but_can_be_seen_and_deleted(
    client: FlaskClient, service: Service, torso: bytes, lines: Lines, full: Callable[[bool], None]
) -> None:
    made = client.post("/api/scans", data={"file": (io.BytesIO(torso), "torso.ply")}).json
    place = f"/api/patients/{made['patient']}"
    before = len(lines())
    full(True)
    refused = client.patch(place, json={"code": "other"})
    assert (refused.status_code, refused.json["detail"][:14]) == (507, "The service's ")
    assert client.get(place).json["code"] != "other"
    assert client.delete(place).status_code == 204
    assert client.get(place).status_code == 404
    full(False)
    assert [line["what"] for line in lines()[before:]] == ["open", "delete", "done"]
    assert not check(service.storage.root).fault
