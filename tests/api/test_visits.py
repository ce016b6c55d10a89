"""The day of a scan is said over HTTP, and what the dated scans say is asked for."""

import pytest
from flask.testing import FlaskClient
from helpers.problems import problem


@pytest.fixture
def patient(client: FlaskClient, scan_id: str) -> str:
    """Of the scan."""
    answer = client.get(f"/api/scans/{scan_id}").json
    assert answer is not None
    return str(answer["patient"])


def test_a_visit_is_said_read_and_taken_back(client: FlaskClient, scan_id: str, patient: str) -> None:
    place, said = f"/api/scans/{scan_id}/visit", {"date": "2026-03-01", "label": "before"}
    unknown = {"scan": scan_id, "date": None, "label": ""}
    assert client.get(f"/api/patients/{patient}/visits").json == {"scans": [unknown]}
    assert client.put(place, json=said).json == said | {"scan": scan_id}
    assert client.get(f"/api/patients/{patient}/visits").json == {"scans": [said | {"scan": scan_id}]}
    assert client.put(place, json={"date": None}).json == unknown


def test_the_name_of_a_visit_is_nobodys_sentence_and_stays_as_it_was_typed(
    client: FlaskClient, scan_id: str, patient: str
) -> None:
    german, said = {"Accept-Language": "de"}, {"date": "2026-03-01", "label": "left"}
    answer = said | {"scan": scan_id}
    assert client.put(f"/api/scans/{scan_id}/visit", json=said, headers=german).json == answer
    assert client.get(f"/api/patients/{patient}/visits", headers=german).json == {"scans": [answer]}


@pytest.mark.parametrize("day", ["today", "2999-01-01", "2026-02-30"])
def test_what_is_no_day_is_refused_with_a_sentence(client: FlaskClient, scan_id: str, day: str) -> None:
    answer = client.put(f"/api/scans/{scan_id}/visit", json={"date": day})
    assert problem(answer, 422).startswith(day)


def test_a_patient_without_visits_has_nothing_to_compare(
    client: FlaskClient, fit_id: str, scan_id: str, patient: str
) -> None:
    """Of one scan."""
    document = client.get(f"/api/patients/{patient}/visits.json").json
    assert document is not None
    assert (document["schema"], document["stances"], document["asked"]) == ("breastrig/visits@1", [], [])
    plots = client.get(f"/api/patients/{patient}/visits.svg?stance=standing")
    assert "Fewer than two standing scans" in problem(plots, 404)
    map_of = client.get(f"/api/patients/{patient}/change.png?scan={scan_id}&with=gone")
    assert "has no fit that is done" in problem(map_of, 404)


@pytest.mark.parametrize("place", ["visits", "visits.json", "visits.svg?stance=supine", "change.glb?scan=a&with=b"])
def test_no_such_patient(client: FlaskClient, place: str) -> None:
    problem(client.get(f"/api/patients/{'x' * 22}/{place}"), 404)
