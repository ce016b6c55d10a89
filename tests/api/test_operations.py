"""What those who run the service may ask: alive, ready, busy."""

import io
import os
import signal
import sqlite3
from pathlib import Path

import pytest
from flask.testing import FlaskClient
from helpers import fake_fit
from helpers.problems import problem
from helpers.waiting import ended, until
from prometheus_client.parser import text_string_to_metric_families

from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.execution.limits import FitLimits
from breastrig.service import readiness
from breastrig.service.readiness import Readiness
from breastrig.service.service import Service
from breastrig.storage.storage import Storage
from breastrig_studies.output.rig_files import write_rig


def locked() -> None:
    raise sqlite3.OperationalError("database is locked")


def numbers(client: FlaskClient) -> dict[tuple[str, ...], float]:
    """(name, label values...) -> value, of every sample."""
    text = client.get("/metrics").get_data(as_text=True)
    samples = [sample for family in text_string_to_metric_families(text) for sample in family.samples]
    return {(one.name, *one.labels.values()): one.value for one in samples}


def test_a_running_service_is_alive_and_ready(client: FlaskClient) -> None:
    assert client.get("/healthz").json == {"status": "ok"}
    answer = client.get("/readyz")
    assert (answer.status_code, answer.json) == (200, {"status": "ready"})


def test_what_keeps_a_service_from_working_is_named(
    config: Config, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from helpers.toy_rig import toy_rig

    monkeypatch.setattr(readiness, "KEPT_S", 0.0)
    monkeypatch.setattr(readiness, "WAIT_S", 0.2)
    write_rig(toy_rig(), tmp_path)
    mine = Config(model=tmp_path / "toy.glb", examples=config.examples, web=config.web)
    service = Service(Storage(tmp_path / "data"), model=mine.model, fits=FitLimits(workers=1, grace_s=0.1))
    with service.started():
        client = create_app(mine, service).test_client()
        monkeypatch.setattr(readiness, "WAIT_S", 20.0)
        assert client.get("/readyz").status_code == 200
        monkeypatch.setattr(readiness, "WAIT_S", 0.2)
        monkeypatch.setattr(service.storage.index, "writing", locked)
        assert "The index cannot be written." in problem(client.get("/readyz"), 503)
        monkeypatch.delattr(service.storage.index, "writing")
        monkeypatch.setattr(service.storage, "has_room", lambda: False)
        assert "The data folder cannot be written." in problem(client.get("/readyz"), 503)
        monkeypatch.delattr(service.storage, "has_room")
        (tmp_path / "toy.glb").unlink()
        monkeypatch.setattr(readiness, "WAIT_S", 20.0)
        answer = client.get("/readyz")
        assert problem(answer, 503) == "The model's file is gone or another one."
        assert int(answer.headers["Retry-After"]) > 0
    assert "processes that read uploads do not answer" in problem(client.get("/readyz"), 503)


def test_metrics_count_requests_uploads_and_fits_and_name_nobody(
    config: Config, model: Path, tmp_path: Path, torso: bytes
) -> None:
    service = Service(
        Storage(tmp_path / "data"), runner=fake_fit.mostly_patient, model=model, fits=FitLimits(workers=1, grace_s=0.1)
    )
    with service.started():
        client = create_app(config, service).test_client()
        scan = client.post("/api/scans", data={"file": (io.BytesIO(torso), "torso.ply")}).json["id"]
        client.post("/api/scans", data={"file": (io.BytesIO(b"no scan"), "torso.ply")})
        done = client.post("/api/fits", json={"scan": scan, "drawing": None}).json["id"]
        ended(service, done)
        running, _ = (client.post("/api/fits", json={"scan": scan, "preset": "paper"}).json["id"] for _ in range(2))
        until(lambda: client.get(f"/api/fits/{running}").json["state"] == "running", "a running fit")
        client.get("/api/fits/nobody")
        client.get("/nowhere/at/all")
        until(lambda: numbers(client).get(("breastrig_fit_seconds_count", "done")) == 1, "the counted fit")
        found = numbers(client)
        assert found["breastrig_uploads_total", "yes"] == found["breastrig_uploads_total", "no"] == 1
        assert found["breastrig_requests_total", "POST", "/api/scans", "201"] == 1
        assert found["breastrig_requests_total", "POST", "/api/scans", "422"] == 1
        assert found["breastrig_requests_total", "GET", "/api/fits/<fit_id>", "404"] == 1
        assert found["breastrig_request_seconds_count", "POST", "/api/fits"] == 3
        states = {state: found["breastrig_fits", state] for state in ("queued", "running", "done", "failed")}
        assert states == {"queued": 1, "running": 1, "done": 1, "failed": 0}
        assert (found["breastrig_queue_length",], found["breastrig_workers",]) == (1, 1)
        text = client.get("/metrics").get_data(as_text=True)
        assert not any(secret in text for secret in (scan, done, running, "nobody", "nowhere", "torso"))


def test_metrics_are_shown_to_this_machine_only(client: FlaskClient) -> None:
    for address, status in (("127.0.0.1", 200), ("::1", 200), ("192.0.2.7", 403), ("2001:db8::1", 403)):
        answer = client.get("/metrics", environ_overrides={"REMOTE_ADDR": address})
        assert answer.status_code == status
    problem(answer, 403)


def test_operations_need_no_token_and_show_nothing_that_needs_one(config: Config, client_for) -> None:
    client = client_for(Config(model=config.model, examples=config.examples, web=config.web, token="x" * 20))
    assert [client.get(place).status_code for place in ("/healthz", "/readyz", "/metrics")] == [200, 200, 200]
    assert client.get("/api/meta").status_code == 401


def test_a_killed_idle_process_does_not_make_the_service_unready(service: Service) -> None:
    os.kill(service.pool.queue(1, 2**32).result(os.getpid, (), 30.0, "idle"), signal.SIGKILL)
    readiness = Readiness(service.storage, {"fit": service.pool.queue(1, 2**32)})
    assert readiness.troubles() == ()
