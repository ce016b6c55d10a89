"""A rig's day: a forearm, made by data only, from the check of its files to the link that shows its fit."""

import io
import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from flask.testing import FlaskClient
from helpers.forearm import posed_forearm, write_forearm
from helpers.waiting import ended

import breastrig
from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.cli.main import main
from breastrig.execution.limits import FitLimits
from breastrig.gltf.read_rig import default_rig_path
from breastrig.service.service import Service
from breastrig.storage.storage import Storage


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, Path]:
    return write_forearm(tmp_path_factory.mktemp("arm"))


@pytest.fixture(scope="module")
def served(
    arm: tuple[Path, Path, Path], tmp_path_factory: pytest.TempPathFactory
) -> Iterator[tuple[Service, FlaskClient]]:
    storage = Storage(tmp_path_factory.mktemp("data"))
    service = Service(storage, fits=FitLimits(workers=1, grace_s=0.1), model=arm[0])
    with service.started():
        yield service, create_app(Config(model=arm[0]), service).test_client()


@pytest.mark.usefixtures("batch_here")
@pytest.mark.slow
def test_by_command_line(arm: tuple[Path, Path, Path], tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    model, scan, places = map(str, arm)
    out, rep = str(tmp_path / "out"), tmp_path / "report"
    assert main(["model", "check", "--model", model]) == 0
    assert "BAD" not in capfd.readouterr().out
    assert main(["fit", scan, "--units", "mm", "--landmarks", places, "--model", model, "-o", out]) == 0
    assert main(["report", out, "--model", model, "-o", str(rep)]) == 0
    assert main(["transfer", "--from", out, "--to", out, "--model", model, "-o", str(tmp_path / "there.json")]) == 0
    assert main(["export", out, "--model", model, "-o", str(tmp_path / "export")]) == 0
    assert main(["landmarks", scan, "--units", "mm", "--model", model, "-o", str(tmp_path / "proposed.json")]) == 0
    table = tmp_path / "manifest.csv"
    table.write_text(f"scan,landmarks,name,units\n{scan},{places},again,mm\n", "utf-8")
    assert main(["batch", str(table), "--model", model, "--jobs", "1", "-o", str(tmp_path / "batch")]) == 0
    assert (tmp_path / "batch" / "again" / "fitted.ply").read_bytes() == (Path(out) / "fitted.ply").read_bytes()
    assert main(["batch", str(table), "--model", model, "--scheduler", "tcp://a:1", "-o", str(tmp_path / "far")]) == 2
    said = capfd.readouterr().err
    assert said.endswith("have a rig of your own; run its batch here, without --scheduler.\n")
    assert "Traceback" not in said
    fit = breastrig.Fit.load(out, model)
    truth = 1e3 * posed_forearm(fit.model)[0]
    assert np.linalg.norm(fit.vertices - truth, axis=1).mean() < 3.0
    assert [line.name for line in fit.drawing.lines] == ["palmar"]
    assert (fit.verdict.level, fit.result["landmark_uncertainty_mm"]) == ("uncalibrated", {})
    assert fit.verdict.reasons[0].startswith("Not calibrated for this rig: ")
    assert fit.result["not_calibrated"].startswith("Not calibrated for this rig: ")
    [straight, tape] = breastrig.measure(fit)
    assert (straight.name, straight.left, tape.kind) == ("radius", None, "along the skin")
    assert straight.value is not None
    assert straight.value.value == pytest.approx(232.0, abs=2.0)
    assert json.loads((rep / "report.json").read_text())["measures"][0]["label"] == "Length of the radius"


@pytest.mark.slow
def test_it_brings_what_is_known_of_it(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    model, scan, places = write_forearm(tmp_path / "arm")
    shutil.copytree(default_rig_path().with_suffix(".known"), model.with_suffix(".known"))
    assert main(["model", "bind", "--model", str(model)]) == 0
    capfd.readouterr()
    assert main(["model", "check", "--model", str(model)]) == 2  # tetrahedra are of one rig
    assert "volume.json does not belong to this rig; mend it or take it away." in capfd.readouterr().err
    (model.with_suffix(".known") / "volume.json").unlink()
    assert main(["model", "check", str(model)]) == 0
    assert "tip" not in capfd.readouterr().out
    side = json.loads(model.with_suffix(".json").read_text())
    side["landmarks"][0]["remark"] = side["skining"] = "linear"
    model.with_suffix(".json").write_text(json.dumps(side))
    assert main(["model", "check", str(model)]) == 0  # a newer file, or a misspelled word
    assert "tip all keys of the side file are read: landmarks.0.remark, skining\n" in capfd.readouterr().out
    assert main(["model", "bind", str(model)]) == 0
    fit = breastrig.fit(breastrig.read_scan(scan, "mm"), places, model=model)
    assert (fit.verdict.level, fit.result.get("not_calibrated")) == ("good", None)
    assert set(fit.result["landmark_uncertainty_mm"]) == set(fit.model.landmark_names)
    assert np.isfinite(np.frombuffer(fit.files["uncertainty.bin"], "<f4")).all()
    [straight, _] = breastrig.measure(fit)
    assert straight.value is not None
    assert straight.value.low is not None


@pytest.mark.slow
def test_by_http(served: tuple[Service, FlaskClient], arm: tuple[Path, Path, Path]) -> None:
    service, client = served
    data, landmarks = arm[1].read_bytes(), json.loads(arm[2].read_text())["landmarks"]
    meta = client.get("/api/meta").json
    assert [drawing["name"] for drawing in meta["drawings"]] == ["incision"]
    assert [pattern["name"] for pattern in meta["patterns"]] == ["tumour_at"]  # which needs no landmark
    sent = client.post("/api/scans", data={"file": (io.BytesIO(data), "scan.ply"), "units": "mm"})
    assert sent.status_code == 201, sent.json
    links = sent.json["links"]
    assert client.put(links["landmarks"], json={"landmarks": landmarks}).status_code == 200
    assert client.get(links["proposed"]).status_code == 200
    asked = client.post("/api/fits", json={"scan": sent.json["id"], "drawing": "incision"})
    assert asked.status_code == 202, asked.json
    fit = ended(service, asked.json["id"])
    assert fit.state == "done", fit.reason
    shown = client.get(f"/api/fits/{fit.id}").json
    posted = ("cancel", "shares", "moved", "predictions", "events")
    read = [link for name, link in shown["links"].items() if name not in posted]
    for link in read:
        with client.get(link) as answer:
            assert answer.status_code == 200, (link, answer.data)
    predicted = client.post(shown["links"]["predictions"], json={"stance": "prone"})
    assert predicted.status_code == 422
    assert "is not known; only the package's own model predicts." in predicted.json["detail"]
    moved = client.post(shown["links"]["moved"], json={"landmarks": {"wrist_crease": landmarks["wrist_crease"]}})
    assert moved.status_code == 200, moved.json
    [straight, _] = client.get(f"/api/fits/{fit.id}/measures.json").json["measures"]
    assert straight["label"] == "Length of the radius"
    report = client.get(f"/api/fits/{fit.id}/report.pdf")
    assert report.data.startswith(b"%PDF")
    own = {
        "schema": "breastrig/drawing@1",
        "unit": "mm",
        "shapes": [{"name": "mine", "points": [landmarks["wrist_crease"], landmarks["elbow_crease"]]}],
    }
    put = client.put(links["drawing"], json=own)
    assert put.status_code == 200, put.json
    share = client.post(f"/api/fits/{fit.id}/shares", json={})
    assert share.status_code == 201, share.json
