"""POST /api/fits with `with`: two stances of one patient, two fits, one job."""

import io
from collections.abc import Iterator

import pytest
from flask.testing import FlaskClient
from helpers.problems import problem
from helpers.waiting import ended, until

from breastrig.service.service import Service
from breastrig.storage.rows.fits import fit_ids


@pytest.fixture
def lying(client: FlaskClient, torso: bytes) -> Iterator[str]:
    """A second scan."""
    scan_id = client.post("/api/scans", data={"file": (io.BytesIO(torso), "torso.ply")}).json["id"]
    yield scan_id
    client.delete(f"/api/scans/{scan_id}")


@pytest.mark.slow
def test_two_stances_are_accepted_and_each_has_its_own_fit(
    client: FlaskClient, service: Service, scan_id: str, lying: str
) -> None:
    stored, given = {"nipple_L": [70.0, 350.0, 120.0]}, {"nipple_R": [-70.0, 350.0, 120.0]}
    client.put(f"/api/scans/{lying}/landmarks", json={"landmarks": stored, "certain": list(stored)})
    body = {"scan": scan_id, "stance": "standing", "landmarks": given, "drawing": "lumpectomy", "refine": True}
    answer = client.post("/api/fits", json={**body, "with": {"scan": lying, "stance": "supine"}})
    assert answer.status_code == 202
    first, second = answer.json, answer.json["partner"]
    assert answer.headers["Location"] == first["links"]["self"]
    for one, other, scan, stance, landmarks in (
        (first, second, scan_id, "standing", given),
        (second, first, lying, "supine", stored),
    ):
        ended(service, one["id"])
        fit = client.get(one["links"]["self"]).json
        assert (fit["state"], fit["scan"], fit["stance"], fit["partner"]) == ("done", scan, stance, other["id"])
        assert (fit["drawing"], fit["refine"], fit["links"]) == ("lumpectomy", True, one["links"])
        assert client.get(one["links"]["result"]).json["landmarks_given"] == landmarks
        assert client.get(one["links"]["result"]).json["certain"] == (["nipple_L"] if one is second else [])
        events = client.get(one["links"]["events"] + ".json").json["events"]
        assert [each["event"]["kind"] for each in events] == ["started", *["iterated"] * 4, "done"]
        assert client.get(f"{one['links']['self']}/iterations/3.gltf").status_code == 200


def test_a_fit_of_one_scan_has_no_partner(client: FlaskClient, service: Service, scan_id: str) -> None:
    answer = client.post("/api/fits", json={"scan": scan_id, "drawing": None}).json
    assert answer["partner"] is None
    ended(service, answer["id"])


@pytest.mark.slow
@pytest.mark.parametrize("which", ["first", "partner"])
def test_cancelling_either_cancels_both(
    client: FlaskClient, service: Service, scan_id: str, lying: str, which: str
) -> None:
    first = client.post(
        "/api/fits", json={"scan": scan_id, "preset": "paper", "drawing": None, "with": {"scan": lying}}
    )
    pair = {"first": first.json, "partner": first.json["partner"]}
    until(lambda: client.get(pair["partner"]["links"]["self"]).json["iterations"] > 0, "an iteration")
    assert client.post(pair[which]["links"]["cancel"]).json["state"] == "cancelled"
    for one in pair.values():
        assert client.get(one["links"]["self"]).json["state"] == "cancelled"


def test_deleting_one_scan_leaves_the_other_fit_without_a_partner(
    client: FlaskClient, service: Service, scan_id: str, lying: str
) -> None:
    first = client.post("/api/fits", json={"scan": scan_id, "drawing": None, "with": {"scan": lying}}).json
    for one in (first, first["partner"]):
        ended(service, one["id"])
    client.delete(f"/api/scans/{lying}")
    assert client.get(first["links"]["self"]).json["partner"] is None
    assert client.get(first["links"]["result"]).status_code == 200
    problem(client.get(first["partner"]["links"]["self"]), 404)


def test_a_pair_that_is_asked_for_again_with_its_key_is_the_same_pair(
    client: FlaskClient, service: Service, scan_id: str, lying: str
) -> None:
    body = {"scan": scan_id, "drawing": None, "with": {"scan": lying}}
    answers = [client.post("/api/fits", json=body, headers={"Idempotency-Key": "k-pair"}).json for _ in range(2)]
    assert answers[0] == answers[1]
    for one in (answers[0], answers[0]["partner"]):
        ended(service, one["id"])
    assert len(list((service.storage.root / "fits").iterdir())) == len(fit_ids(service.storage))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("other", "status", "word"),
    [
        ({"scan": "nobody"}, 404, "no such scan"),
        ({}, 422, "with.scan: Field required."),
        ({"stance": "sitting"}, 422, "with.stance"),
        ({"landmarks": {"elbow": [0, 0, 0]}}, 422, '"elbow" is not a landmark'),
        ({"preset": "paper"}, 422, "with.preset: Extra inputs are not permitted."),
    ],
)
def test_a_second_stance_that_cannot_be_meant_is_refused(
    client: FlaskClient, service: Service, scan_id: str, lying: str, other, status: int, word: str
) -> None:
    before = fit_ids(service.storage)
    given = other if not other or "scan" in other else {"scan": lying, **other}
    answer = client.post("/api/fits", json={"scan": scan_id, "drawing": None, "with": given})
    assert word in problem(answer, status)
    assert fit_ids(service.storage) == before


def test_a_scan_is_not_its_own_second_stance(client: FlaskClient, scan_id: str) -> None:
    answer = client.post("/api/fits", json={"scan": scan_id, "drawing": None, "with": {"scan": scan_id}})
    assert "two scans" in problem(answer, 422)
