"""A scan is uploaded for one of the package's models, and everything after goes by that one."""

import io
from collections.abc import Iterator

import pytest
import trimesh
from flask.testing import FlaskClient
from helpers.blank_pictures import blank_pictures_in_reports
from helpers.waiting import ended

from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.execution.limits import FitLimits
from breastrig.service.service import Service
from breastrig.storage.storage import Storage
from breastrig.use.values.model import load_model


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Service, FlaskClient]]:
    service = Service(Storage(tmp_path_factory.mktemp("data")), fits=FitLimits(workers=1, grace_s=0.1))
    with service.started():
        yield service, create_app(Config(), service).test_client()


def upload(client: FlaskClient, **fields: str):
    rig = load_model("male")
    skin = trimesh.Trimesh(rig.template, rig.faces, process=False).export(file_type="ply")
    return client.post("/api/scans", data={"file": (io.BytesIO(skin), "scan.ply"), "units": "m", **fields})


def test_a_mans_scan_is_fitted_with_the_chest_of_a_man(
    served: tuple[Service, FlaskClient], monkeypatch: pytest.MonkeyPatch
) -> None:
    blank_pictures_in_reports(monkeypatch)
    service, client = served
    rig = load_model("male")
    meta = client.get("/api/meta").json
    assert (meta["model"]["name"], meta["models"]) == ("torso", ["torso", "male"])
    his = client.get("/api/meta?model=male").json
    assert (his["model"]["sha256"], [d["name"] for d in his["drawings"]][:3]) == (rig.sha256, list(rig.drawing_names))
    assert client.get("/api/meta?model=female").status_code == 404
    wrong = upload(client, model="female")
    assert (wrong.status_code, wrong.json["detail"]) == (404, '"female" is not a model; known are: torso, male.')
    scan = upload(client, model="male").json
    assert scan["model"] == "male"
    standard = upload(client).json
    assert (standard["model"], standard["model_said"], scan["model_said"]) == ("torso", False, False)
    his_model, himself = f"{scan['links']['self']}/model", scan["links"]["self"]
    wrong = client.put(his_model, json={"model": "torso"})
    assert (wrong.status_code, wrong.json["detail"]) == (
        409,
        'The scan was uploaded for the model "male". For another model upload its file again.',
    )
    assert client.get(himself).json["model_said"] is False
    assert client.put(his_model, json={"model": "male"}).json["model_said"] is True
    assert client.get(himself).json["model_said"] is True
    points = 1e3 * rig.landmark_points().positions(rig.template, rig.faces)
    landmarks = dict(zip(rig.landmark_names, points.tolist(), strict=True))
    assert client.put(scan["links"]["landmarks"], json={"landmarks": landmarks}).status_code == 200
    asked = client.post("/api/fits", json={"scan": scan["id"], "drawing": "gynaecomastia"})
    assert asked.status_code == 202, asked.json
    fit = ended(service, asked.json["id"])
    assert fit.state == "done", fit.reason
    with client.get(f"/api/fits/{fit.id}/result.json") as answer:
        result = answer.json
    assert (result["model"]["name"], result["model"]["sha256"]) == ("male", rig.sha256)
    assert result["surface_distance_mm"]["mean"] < 1.0
    assert client.get(f"/api/models/{rig.sha256}/torso.json").json["name"] == "male"
    predicted = client.post(f"/api/fits/{fit.id}/predictions", json={"stance": "supine"})
    assert "What gravity does to male is not known" in predicted.json["detail"]
    with client.get(f"/api/fits/{fit.id}/report.pdf") as answer:
        assert answer.data.startswith(b"%PDF")
