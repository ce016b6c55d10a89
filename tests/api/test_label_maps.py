"""An MRI's label map as a scan of a patient: what it shows inside is in her plan by itself."""

import gzip
import io
import json

import numpy as np
import pytest
from flask.testing import FlaskClient
from helpers.label_maps import (
    BODY_WORDS,
    LESION,
    PLAIN,
    RADIUS,
    SIZES,
    body_labels,
    coarse_labels,
    file_of,
    masks,
    placed_nifti,
    seg,
)
from helpers.on_disk import bytes_below

from breastrig.service.service import Service


@pytest.mark.slow
def test_a_lesion_of_a_label_map_is_an_item_of_the_plan(client: FlaskClient) -> None:
    data = gzip.compress(coarse_labels())
    answer = client.post("/api/scans", data={"file": (io.BytesIO(data), "IM000001")})
    assert answer.status_code == 201, answer.json
    assert answer.json is not None
    scan = answer.json
    assert (scan["unit"], scan["triangles"] > 5_000) == ("mm", True)
    assert (scan["stance"]["proposed"], "breast MRI" in scan["stance"]["reason"]) == ("prone", True)
    plan = client.get(scan["links"]["plan"]).json
    assert plan is not None
    (lesion,) = plan["items"]
    assert (lesion["kind"], lesion["scan"], lesion["name"]) == ("lesion", scan["id"], "Lesion 1")
    assert lesion["center"] == pytest.approx(LESION.tolist(), abs=0.5)
    assert lesion["radius_mm"] == pytest.approx(RADIUS, abs=0.2)
    assert client.delete(scan["links"]["self"]).status_code == 204
    assert client.get(scan["links"]["plan"]).status_code == 404


def test_the_side_is_asked_and_the_answer_sent_with_the_file(client: FlaskClient) -> None:
    """Nothing is kept of a file about which something has to be asked first."""
    labels = np.asfortranarray(body_labels()[::-1, ::-1, ::2])
    data = gzip.compress(placed_nifti(labels, *[(np.diag([*SIZES * [1.0, 1.0, 2.0], 1.0]), 0)] * 2))
    before = client.get("/api/scans").json
    asked = client.post("/api/scans", data={"file": (io.BytesIO(data), "a.nii")})
    assert (asked.status_code, asked.mimetype) == (422, "application/problem+json")
    assert asked.json is not None
    assert "does not say which side is left" in asked.json["detail"]
    question = asked.json["question"]
    assert (question["field"], question["problem"] in asked.json["detail"]) == ("frame", True)
    assert [each["value"] for each in question["choices"]][:4] == ["RAS", "LAS", "RAI", "LAI"]
    assert question["choices"][0]["lesions"][0]["side"] == "L"
    assert client.get("/api/scans").json == before
    answer = client.post("/api/scans", data={"file": (io.BytesIO(data), "a.nii"), "frame": "LAS"})
    assert answer.status_code == 201, answer.json
    assert answer.json is not None
    plan = client.get(answer.json["links"]["plan"]).json
    assert plan is not None
    (lesion,) = plan["items"]
    assert lesion["center"][0] < -55.0
    assert "This is no frame" in client.post(
        "/api/scans", data={"file": (io.BytesIO(data), "a.nii"), "frame": "RLS"}
    ).get_data(as_text=True)


def test_segments_are_answered_and_can_be_chosen(client: FlaskClient) -> None:
    data = gzip.compress(coarse_labels())
    answer = client.post("/api/scans", data={"file": (io.BytesIO(data), "a.nii")})
    assert answer.json is not None
    facts = [(each["number"], each["name"], each["taken_as"]) for each in answer.json["segments"]]
    assert facts == [(1, "Tissue 1", "tissue"), (2, "Lesion 1", "lesion"), (3, "Tissue 2", "tissue")]
    assert answer.json["segments"][1]["radius_mm"] == pytest.approx(RADIUS, abs=0.2)
    assert [each["label"] for each in answer.json["segments"]] == ["", "", ""]
    chosen = json.dumps({"2": "tissue"})
    answer = client.post("/api/scans", data={"file": (io.BytesIO(data), "a.nii"), "segments": chosen})
    assert answer.json is not None
    assert answer.json["segments"][1]["taken_as"] == "tissue"
    plan = client.get(answer.json["links"]["plan"]).json
    assert plan is not None
    assert plan["items"] == []
    refused = client.post("/api/scans", data={"file": (io.BytesIO(data), "a.nii"), "segments": '{"9": "lesion"}'})
    assert refused.status_code == 422
    assert refused.json is not None
    assert "segment" in refused.json["detail"].lower()


def test_the_files_words_are_answered_once_and_kept_nowhere(
    client: FlaskClient, service: Service, caplog: pytest.LogCaptureFixture
) -> None:
    """A segment may bear the patient's name."""
    caplog.set_level("DEBUG")
    name = "Zoe Quixote"
    data = gzip.compress(file_of(seg(masks(), {1: BODY_WORDS, 2: (name, *PLAIN[1:])})))
    answer = client.post("/api/scans", data={"file": (io.BytesIO(data), "a.dcm.gz")})
    assert answer.status_code == 201, answer.json
    assert answer.json is not None
    assert [each["label"] for each in answer.json["segments"]] == ["Body Breast", f"{name} Tissue"]
    scan = client.get(answer.json["links"]["self"])
    assert scan.json is not None
    assert scan.json["segments"] == [
        {key: value for key, value in each.items() if key != "label"} for each in answer.json["segments"]
    ]
    plan = client.get(answer.json["links"]["plan"])
    assert name not in scan.get_data(as_text=True) + plan.get_data(as_text=True) + caplog.text
    stored = bytes_below(service.storage.root)
    assert len(stored) > 1000
    assert b"Quixote" not in stored
