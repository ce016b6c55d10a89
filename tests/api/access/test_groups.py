"""Groups own patients: a stranger finds nothing, a reader changes nothing, at each route of the application's map."""

import io
import json
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import pytest
from apiflask import APIFlask
from flask.testing import FlaskClient
from helpers.persons import person_client
from helpers.problems import problem
from helpers.waiting import ended
from werkzeug.test import TestResponse

from breastrig.api.access.person import Role
from breastrig.api.access.roles import LEAST, OPEN, least_role
from breastrig.api.config import Config
from breastrig.cases.case_folder import CaseFolder
from breastrig.service.service import Service

Call = tuple[str, str, str]  # method, rule, endpoint
IDS = ("<patient_id>", "<scan_id>", "<fit_id>")
OTHERS = {  # calls that name a patient's things in their body or not at all, with what a stranger sends
    "scans.upload_scan": {"data": {"file": b"a file", "patient": "PATIENT"}},
    "fits.start_fit": {"json": {"scan": "SCAN"}},
    "transfers.transfer_drawing": {"json": {"from_fit": "FIT", "to_fit": "FIT"}},
    "transfers.propose_marks": {"json": {"from_fit": "FIT", "to_fit": "FIT"}},
    "audit.show_certificate": {},
}
OF_NOBODY = {  # they say nothing about a patient
    "meta.about", "meta.list_examples", "meta.open_example", "meta.show_protocol", "docs.show_docs",
    "docs.show_openapi", "docs.show_style", "models.show_buffer", "models.show_drawing_buffer", "models.show_model",
    "models.show_side", "models.show_version", "models.show_version_side", "persons.stay",
}  # fmt: skip
LISTS = {"patients.list_patients": "patients", "scans.list_scans": "scans", "fits.list_fits": "fits"}


@dataclass(frozen=True)
class North:
    """A patient of the group north."""

    patient: str
    scan: str
    fit: str
    share: str

    def address(self, rule: str) -> str:
        ids = {"patient_id": self.patient, "scan_id": self.scan, "fit_id": self.fit, "share_id": self.share}
        ids["deleted_id"] = self.patient
        ids |= {"version": "1", "iteration": "0", "name": "standing", "kind": "pp", "sha256": "0" * 64}
        return re.sub(r"<(?:\w+:)?(\w+)>", lambda found: ids[found[1]], rule)

    def given(self, call: Call) -> dict[str, Any]:
        text = json.dumps(OTHERS.get(call[2], {}), default=bytes.decode)
        for name, one in (("PATIENT", self.patient), ("SCAN", self.scan), ("FIT", self.fit)):
            text = text.replace(name, one)
        sent: dict[str, Any] = json.loads(text)
        if "data" in sent:
            sent["data"]["file"] = (io.BytesIO(sent["data"]["file"].encode()), "scan.ply")
        return sent


@pytest.fixture
def person(client_for, config: Config) -> Callable[..., FlaskClient]:
    return lambda name, *groups: person_client(client_for, config, name, *groups)


@pytest.fixture
def planner(person) -> FlaskClient:
    return person("anna", "north")


@pytest.fixture
def administrator(person) -> FlaskClient:
    return person("root")


def upload(client: FlaskClient, torso: bytes, **fields: str) -> TestResponse:
    return client.post("/api/scans", data={"file": (io.BytesIO(torso), "torso.ply"), **fields})


@pytest.fixture
def north(planner: FlaskClient, service: Service, torso: bytes) -> Iterator[North]:
    uploaded = upload(planner, torso).json
    fit = planner.post("/api/fits", json={"scan": uploaded["id"], "drawing": "lumpectomy"}).json["id"]
    assert ended(service, fit).state == "done"
    share = planner.post(f"/api/fits/{fit}/shares", json={}).json["id"]
    yield North(uploaded["patient"], uploaded["id"], fit, share)
    service.delete_patient(uploaded["patient"])


def calls_of(app: APIFlask) -> list[Call]:
    return sorted(
        (method, rule.rule, rule.endpoint)
        for rule in app.url_map.iter_rules()
        for method in (rule.methods or set()) - {"HEAD", "OPTIONS"}
        if rule.endpoint.partition(".")[0] not in OPEN
    )


def ask(client: FlaskClient, call: Call, north: North) -> TestResponse:
    return client.open(north.address(call[1]), method=call[0], **north.given(call))


def test_every_route_has_a_role_and_the_exceptions_are_routes(app: APIFlask) -> None:
    endpoints = {rule.endpoint: rule for rule in app.url_map.iter_rules()}
    assert set(LEAST) <= set(endpoints)
    below = {rule.endpoint for rule in endpoints.values() if not rule.rule.startswith("/api/")}
    visitors = {endpoint for endpoint in endpoints if endpoint.startswith("shared.")}
    assert {endpoint for endpoint in endpoints if least_role(endpoint, "GET") is None} == below | visitors
    for method, _, endpoint in calls_of(app):
        assert least_role(endpoint, method) is LEAST.get(endpoint, Role.LOOK if method == "GET" else Role.PLAN)


def test_a_stranger_finds_nothing_at_any_route(app: APIFlask, person, planner, north: North, service: Service) -> None:
    stranger = person("bea", "south", "readers")
    for call in calls_of(app):
        if call[2] == "meta.open_example":
            continue  # makes a patient of the stranger's own
        answer = ask(stranger, call, north)
        if call[2] in LISTS:
            assert answer.json[LISTS[call[2]]] == [], call
            assert len(planner.get(call[1]).json[LISTS[call[2]]]) == 1, call
        elif call[2] in OF_NOBODY:
            assert north.patient.encode() not in answer.data
        elif least_role(call[2], call[0]) is Role.ADMINISTER:
            assert answer.status_code == 403, call
        else:
            assert any(one in call[1] for one in IDS) or call[2] in OTHERS, f"{call}: say what a stranger would send"
            assert (answer.status_code, answer.json.get("question")) == (404, None), (call, answer.json)
    assert planner.get(f"/api/fits/{north.fit}").json["state"] == "done"
    assert planner.get(f"/api/fits/{north.fit}/shares/{north.share}").json["is_open"]


def test_what_is_not_there_and_what_is_of_others_are_answered_alike(app: APIFlask, person, north: North) -> None:
    stranger, nowhere = person("bea", "south"), North("x" * 22, "y" * 22, "z" * 22, "s" * 22)
    for call in calls_of(app):
        if any(one in call[1] for one in IDS):
            known, unknown = (ask(stranger, call, one) for one in (north, nowhere))
            assert (known.status_code, known.json) == (unknown.status_code, unknown.json), call
            assert {name for name, _ in known.headers} == {name for name, _ in unknown.headers}


def test_a_reader_changes_nothing_at_any_route(app: APIFlask, person, north: North, service: Service) -> None:
    reader = person("rose", "readers", "ward")
    CaseFolder(service.storage.root / "cases" / north.patient).give_to("ward")
    before = reader.get(f"/api/patients/{north.patient}").json
    assert before["group"] == "ward"
    for call in calls_of(app):
        if least_role(call[2], call[0]) is not Role.LOOK:
            assert ask(reader, call, north).status_code == 403, call
    assert reader.get(f"/api/patients/{north.patient}").json == before


def test_a_reader_of_the_group_sees_what_its_planner_sees(person, north: North, administrator, planner) -> None:
    """`ward` gives no role: a reader who is in it sees its patients."""
    reader = person("rose", "readers", "ward")
    place = f"/api/patients/{north.patient}"
    problem(reader.get(place), 404)
    given = administrator.put(f"{place}/group", json={"group": "ward"})
    assert (given.status_code, given.json["group"]) == (200, "ward")
    assert [one["id"] for one in reader.get("/api/patients").json["patients"]] == [north.patient]
    for place in (f"/api/fits/{north.fit}/result.zip", f"/api/scans/{north.scan}/mesh.glb"):
        assert reader.get(place).status_code == 200
        problem(planner.get(place), 404)
    assert reader.get(f"/api/fits/{north.fit}/events").status_code == 200


def test_a_patient_of_no_group_is_seen_by_administrators_alone(
    person, administrator, planner, client: FlaskClient, scan_id: str, service: Service
) -> None:
    patient = client.get(f"/api/scans/{scan_id}").json["patient"]
    assert client.get(f"/api/patients/{patient}").json["group"] is None
    problem(planner.get(f"/api/patients/{patient}"), 404)
    assert administrator.get(f"/api/patients/{patient}").status_code == 200
    problem(administrator.put(f"/api/patients/{patient}/group", json={"group": "nobody"}), 422)
    assert administrator.put(f"/api/patients/{patient}/group", json={"group": "north"}).json["group"] == "north"
    assert planner.get(f"/api/patients/{patient}").status_code == 200
    administrator.put(f"/api/patients/{patient}/group", json={"group": None})
    problem(planner.get(f"/api/patients/{patient}"), 404)
    problem(client.put(f"/api/patients/{patient}/group", json={"group": "north"}), 409)  # without users


def test_a_new_patient_is_of_the_group_of_who_makes_it(person, torso: bytes, service: Service, administrator) -> None:
    both, alone = person("cleo", "north", "south"), person("anna", "north")
    refused = problem(upload(both, torso), 422)
    assert "north, south" in refused
    assert "south" in problem(upload(alone, torso, group="south"), 422)
    made = [
        upload(both, torso, group="south").json,
        upload(alone, torso).json,
        upload(administrator, torso, group="ward").json,
        alone.post("/api/examples/standing").json,
        both.post("/api/examples/standing?group=south").json,
        upload(person("dora", "north", "board"), torso, group="north").json,
    ]
    groups = [administrator.get(f"/api/patients/{one['patient']}").json["group"] for one in made]
    assert groups == ["south", "north", "ward", "north", "south", "north"]
    for one in made:
        service.delete_patient(one["patient"])


def test_a_scan_moves_between_patients_in_reach_alone(person, north: North, torso: bytes, service: Service) -> None:
    stranger, planner = person("bea", "south"), person("anna", "north")
    other = upload(stranger, torso).json
    problem(stranger.put(f"/api/scans/{other['id']}/patient", json={"patient": north.patient}), 404)
    problem(planner.put(f"/api/scans/{other['id']}/patient", json={"patient": north.patient}), 404)
    problem(planner.put(f"/api/scans/{north.scan}/patient", json={"patient": other["patient"]}), 404)
    own = planner.put(f"/api/scans/{north.scan}/patient", json={"patient": None}).json
    assert own["group"] == "north"  # that of the patient whose scan it was
    problem(stranger.get(f"/api/patients/{own['id']}"), 404)
    for each in (own["id"], other["patient"]):
        service.delete_patient(each)


def test_a_report_of_two_fits_and_a_start_need_both_in_reach(person, north: North, torso, service: Service) -> None:
    stranger = person("bea", "south")
    scan = upload(stranger, torso).json
    fit = stranger.post("/api/fits", json={"scan": scan["id"]}).json["id"]
    assert ended(service, fit).state == "done"
    for name in ("report.pdf", "report.png", "measures.json", "measures.csv"):
        problem(stranger.get(f"/api/fits/{fit}/{name}?with={north.fit}"), 404)
    problem(stranger.post("/api/fits", json={"scan": scan["id"], "start_from": north.fit}), 404)
    for ends in ((fit, north.fit), (north.fit, fit)):
        problem(stranger.post("/api/transfers", json={"from_fit": ends[0], "to_fit": ends[1]}), 404)
    problem(stranger.get(f"/api/fits/{fit}/shares/{north.share}"), 404)
    problem(stranger.post(f"/api/fits/{fit}/shares/{north.share}/refresh"), 404)
    service.delete_patient(scan["patient"])


def test_who_comes_behind_the_index_is_not_shown(person, planner, north: North, service: Service) -> None:
    """Another program gives the patient to others: the folder says so before the index does."""
    CaseFolder(service.storage.root / "cases" / north.patient).give_to("south")
    assert planner.get("/api/patients").json["patients"] == []
    problem(planner.get(f"/api/patients/{north.patient}"), 404)
    service.storage.index.look()
    assert [one["id"] for one in person("bea", "south").get("/api/patients").json["patients"]] == [north.patient]
    for each in ("scans", "fits"):
        assert planner.get(f"/api/{each}").json[each] == []


def test_a_visitor_of_a_link_sees_what_the_link_shows(planner, north: North, person) -> None:
    url = planner.post(f"/api/fits/{north.fit}/shares", json={}).json["url"]
    visitor = person("")
    opened = visitor.post("/api/shared/open", json={"token": url.removeprefix("/s#")})
    assert opened.status_code == 200
    share = opened.json["id"] if "id" in opened.json else opened.headers["Set-Cookie"].split("share_")[1][:22]
    assert visitor.get(f"/api/shared/{share}/result.json").status_code == 200
    problem(visitor.get(f"/api/fits/{north.fit}"), 401)
