"""Which landmarks to check, by HTTP: for the plan as it is now, for a fit that is done, and never without a reason."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from flask.testing import FlaskClient
from helpers.problems import problem
from helpers.remembered_fits import run_fit_once
from helpers.waiting import ended, until

from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.execution.limits import FitLimits
from breastrig.service.service import Service
from breastrig.storage.storage import Storage


@pytest.mark.slow
def test_a_fit_without_a_known_posterior_says_why_it_has_no_checks(client: FlaskClient, fit_id: str) -> None:
    found = client.get(f"/api/fits/{fit_id}/checks")
    assert found.status_code == 200, found.json
    assert (found.json["checks"], found.json["worth_it"], found.json["expected_line_error_mm"]) == ([], False, None)
    assert found.json["reason"].endswith(".")


def test_a_fit_that_is_not_done_has_no_checks_yet(client: FlaskClient, scan_id: str) -> None:
    fit = client.post("/api/fits", json={"scan": scan_id, "drawing": None, "preset": "paper"}).json
    client.post(fit["links"]["cancel"])
    until(lambda: client.get(fit["links"]["self"]).json["state"] in ("cancelled", "done"), "the end")
    if client.get(fit["links"]["self"]).json["state"] == "cancelled":
        assert "cancelled" in problem(client.get(fit["links"]["checks"]), 409)
    assert "no such fit" in problem(client.get("/api/fits/nobody/checks"), 404)


@pytest.fixture(scope="module")
def real(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Service, FlaskClient]]:
    service = Service(
        Storage(tmp_path_factory.mktemp("real")), runner=run_fit_once, fits=FitLimits(workers=1, grace_s=0.1)
    )
    with service.started():
        yield service, create_app(Config(), service).test_client()


def fitted(service: Service, client: FlaskClient, scan: str, **wishes: Any) -> dict[str, Any]:
    """The links of a fit that is done."""
    fit = client.post("/api/fits", json={"scan": scan, "drawing": "lumpectomy", **wishes}).json
    assert ended(service, fit["id"]).state == "done"
    links: dict[str, Any] = fit["links"]
    return links


@pytest.mark.long
@pytest.mark.slow
def test_the_checks_follow_the_plan_and_end_with_true_places(real: tuple[Service, FlaskClient]) -> None:
    service, client = real
    scan = client.post("/api/examples/supine").json
    true = scan["example_landmarks"]["landmarks"]
    first = fitted(service, client, scan["id"], landmarks={})
    with client.get(first["result"]) as answer:
        result = answer.json
    found = client.get(first["checks"]).json
    assert (found["lines"], found["line_error_mm"]) == ("drawing", result["drawn_line_error_mm"])
    assert found["worth_it"]
    assert found["fingers"] > found["expected_fingers"]
    widths = [found["line_error_mm"], *(each["line_error_mm"] for each in found["checks"])]
    assert widths[-1] == found["expected_line_error_mm"]
    assert (np.diff(widths) <= 0.0).all()
    one = found["checks"][0]
    assert np.linalg.norm(np.subtract(one["place"], true[one["name"]])) < 2.0 * one["radius_mm"], "mm, as landmarks are"

    with client.get(first["drawing"]) as answer:
        line = answer.json["shapes"][0]
    times = 1e3 * {"m": 1.0, "mm": 1e-3}[scan["unit"]]
    own = {"name": "own", "points": (times * np.array(line["points"])).tolist()}
    item = {"kind": "line", "id": "own", "scan": scan["id"], **own}
    plan = {"schema": "breastrig/plan@1", "unit": "mm", "items": [item]}
    assert client.put(f"{scan['links']['patient']}/plan", json=plan, headers={"If-Match": '"0"'}).status_code == 200
    planned = client.get(first["checks"]).json
    assert planned["lines"] == "plan"
    assert planned["line_error_mm"] == pytest.approx(line["line_error_mm"], abs=0.2)

    places = {each["name"]: each["place"] for each in found["checks"]}
    looked_at = dict.fromkeys(places, 1.0)
    checked = fitted(service, client, scan["id"], landmarks=places, confidence=looked_at)
    left = client.get(checked["checks"]).json
    assert {each["name"] for each in left["checks"]}.isdisjoint(places)
    with client.get(checked["result"]) as answer:
        assert answer.json["landmarks_agreed"] == []
        assert answer.json["line_error_mm"] < result["line_error_mm"]

    every = fitted(service, client, scan["id"], landmarks=true)
    nothing = client.get(every["checks"]).json
    assert (nothing["checks"], nothing["worth_it"]) == ([], False)
    assert "has been placed" in nothing["reason"]

    predicted = client.post(first["predictions"], json={"stance": "standing"}).json
    assert ended(service, predicted["id"]).state == "done"
    assert "predicted" in client.get(predicted["links"]["checks"]).json["reason"]
    client.delete(scan["links"]["self"])
    assert client.get(first["checks"]).status_code == 404
