"""A stance that was not scanned, over HTTP: predicted from the example patient's standing scan, by the real work."""

import io
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import pypdf
import pytest
from flask.testing import FlaskClient
from helpers.blank_pictures import blank_pictures_in_reports
from helpers.problems import problem
from helpers.remembered_fits import run_fit_once
from helpers.waiting import ended

from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.fits import find_fit
from breastrig.execution.limits import FitLimits
from breastrig.service import kept_models
from breastrig.service.service import Service
from breastrig.storage.storage import Storage

LESION = {"kind": "lesion", "id": "lump", "name": "lump", "radius_mm": 6.0}
NOT_SCANNED = "Predicted from the standing scan: no scan shows the patient supine."


def text_of(pdf: bytes) -> str:
    """Its words, one blank between them."""
    return " ".join(" ".join(page.extract_text() for page in pypdf.PdfReader(io.BytesIO(pdf)).pages).split())


class Real(NamedTuple):
    """A service with the example patient, fitted standing, predicted supine."""

    service: Service
    client: FlaskClient
    scan: dict[str, Any]
    fit: dict[str, Any]
    predicted: dict[str, Any]
    asked: dict[str, Any]
    """What was posted for the fit, with its key."""

    def predict(self, fit: str, stance: str) -> Any:
        return self.client.post(f"/api/fits/{fit}/predictions", json={"stance": stance})


@pytest.fixture(scope="module")
def real(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Real]:
    storage = Storage(tmp_path_factory.mktemp("predictions"))
    fits = FitLimits(workers=1, grace_s=0.1)
    service = Service(storage, runner=run_fit_once, fits=fits)
    with service.started(), pytest.MonkeyPatch.context() as patch:
        blank_pictures_in_reports(patch)
        client = create_app(Config(), service).test_client()
        scan = client.post("/api/examples/standing").json
        picked = scan["example_landmarks"]["landmarks"]
        document = {"scan": scan["id"], "landmarks": picked, "drawing": "lumpectomy"}
        asked = {"json": document, "headers": {"Idempotency-Key": "once"}}
        fit = client.post("/api/fits", **asked).json
        assert ended(service, fit["id"]).state == "done"
        nipple = np.array(picked["nipple_L"])
        items = [
            {"kind": "pattern", "id": "wise", "scan": scan["id"], "name": "reduction", "parameters": {}},
            LESION | {"scan": scan["id"], "center": (nipple - [10.0, 0.0, 25.0]).tolist()},
        ]
        kept = client.put(scan["links"]["plan"], json={"items": items}, headers={"If-Match": "0"})
        assert kept.status_code == 200, kept.json
        answer = client.post(fit["links"]["predictions"], json={"stance": "supine"})
        assert answer.status_code == 202, answer.json
        row = ended(service, answer.json["id"])
        assert row.state == "done", row.reason
        yield Real(service, client, scan, fit, answer.json, asked)


def test_a_prediction_is_a_fit_that_says_what_it_is_and_is_made_once(real: Real) -> None:
    assert real.predict(real.fit["id"], "supine").json == real.predicted
    shown = real.client.get(real.predicted["links"]["self"]).json
    assert (shown["predicted_from"], shown["stance"]) == (real.fit["id"], "supine")
    events = real.client.get(f"{real.predicted['links']['events']}.json").json["events"]
    assert [each["event"]["kind"] for each in events] == ["started", "done"]
    with real.client.get(real.predicted["links"]["result"]) as file:
        result = file.json
    assert (result["predicted"], result["verdict"]) == (True, {"level": "check", "reasons": [NOT_SCANNED], "about": []})
    (scan,) = real.client.get(f"/api/patients/{real.scan['patient']}").json["scans"]
    assert (scan["stance"], scan["fit"]["id"]) == ("standing", real.fit["id"])  # who was scanned how
    with real.client.get(real.predicted["links"]["fitted_ply"]) as file:
        assert "supine-predicted" in file.headers["Content-Disposition"]


def test_the_key_of_its_fit_stays_with_the_fit(real: Real) -> None:
    assert real.client.post("/api/fits", **real.asked).json["id"] == real.fit["id"]
    case = CaseFolder(real.service.storage.root / "cases" / real.scan["patient"])
    assert find_fit(case, real.fit["id"]).document.key_sha256 is not None
    assert find_fit(case, real.predicted["id"]).document.key_sha256 is None


def test_the_plan_is_carried_onto_it_with_its_error(real: Real) -> None:
    there, here = (real.client.get(each["links"]["plan"]).json for each in (real.predicted, real.fit))
    assert there["missing"] == []
    assert {shape["name"] for shape in there["shapes"]} == {shape["name"] for shape in here["shapes"]} != set()
    assert all(shape["carried"] and min(shape["error_mm"]) > 0.0 for shape in there["shapes"])
    (lesion,) = there["lesions"]
    assert lesion["carried"]
    assert lesion["error_mm"] > 5.0


def test_link_report_and_measures_say_that_it_was_not_scanned(real: Real) -> None:
    measured = real.client.get(f"{real.fit['links']['measures']}?with={real.predicted['id']}").json
    assert [(each["name"], each.get("predicted", False)) for each in measured["stances"]] == [
        ("standing", False),
        ("supine, predicted", True),
    ]
    for scan in ("none", "full"):
        refused = real.client.post(real.predicted["links"]["shares"], json={"scan": scan})
        assert "predicted, not scanned" in problem(refused, 422)
    share = real.client.post(real.predicted["links"]["shares"], json={"scan": "plain"})
    assert share.status_code == 201, share.json
    visitor = real.client.application.test_client()
    links = visitor.post("/api/shared/open", json={"token": share.json["url"].removeprefix("/s#")}).json["links"]
    with visitor.get(links["result"]) as file:
        shown = file.json
    assert (shown["predicted"], shown["stance_reason"]) == (True, NOT_SCANNED)
    with visitor.get(links["report"]) as report:
        text = text_of(report.data)
    assert NOT_SCANNED in text
    assert "Supine, predicted, front: not scanned with the plan" in text
    assert "supine, predicted, from the scan received" in text


def test_what_cannot_be_predicted_is_refused_with_one_sentence(real: Real, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "standing already" in problem(real.predict(real.fit["id"], "standing"), 422)
    assert "itself predicted" in problem(real.predict(real.predicted["id"], "prone"), 422)
    problem(real.predict("nobody", "prone"), 404)
    problem(real.predict(real.fit["id"], "sitting"), 422)
    again = {"scan": real.scan["id"], "start_from": real.predicted["id"]}
    problem(real.client.post("/api/fits", json=again), 422)
    moved = real.client.post(real.predicted["links"]["moved"], json={"landmarks": {}})
    assert "This body is predicted" in problem(moved, 422)
    models = real.service.models
    monkeypatch.setattr(kept_models, "GRAVITY", "another.json")
    assert "gravity" in problem(real.predict(real.fit["id"], "prone"), 422)
    monkeypatch.setitem(vars(models), "_paths", {})
    assert "another version" in problem(real.predict(real.fit["id"], "prone"), 422)


def test_a_prediction_shows_nothing_that_was_cut_away_since_and_goes_with_its_scan(real: Real) -> None:
    cut = {"to_picture": np.eye(4).ravel().tolist(), "lasso": [[0.0, 0.0], [0.01, 0.0], [0.0, 0.01]]}
    asked = {"cuts": [cut]}
    cuts = real.client.put(f"/api/scans/{real.scan['id']}/cuts", json=asked)
    assert cuts.status_code == 200, cuts.json
    assert "cut after" in problem(real.client.get(real.predicted["links"]["report"]), 409)
    files = real.service.storage.files.fit(real.predicted["id"])
    assert files.is_dir()
    assert real.client.delete(f"/api/scans/{real.scan['id']}").status_code == 204
    problem(real.client.get(real.predicted["links"]["self"]), 404)
    assert not files.exists()
