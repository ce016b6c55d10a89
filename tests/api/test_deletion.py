"""DELETE says that all is gone only when it is; a damaged database is noticed and named."""

import io
import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from flask.testing import FlaskClient
from helpers import fake_fit
from helpers.on_disk import of_patients
from helpers.problems import problem
from helpers.waiting import ended, until

from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.execution.limits import FitLimits
from breastrig.index.file import current
from breastrig.service import readiness, sweep
from breastrig.service.service import Service
from breastrig.storage.storage import Storage

LEFT = "breastrig_places_not_removed "


@pytest.fixture
def service(config: Config, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Service]:
    """One of this test alone."""
    monkeypatch.setattr(readiness, "KEPT_S", 0.0)
    service = Service(
        Storage(tmp_path / "data"), runner=fake_fit.quick, model=config.model, fits=FitLimits(workers=1, grace_s=0.1)
    )
    with service.started():
        yield service


@pytest.fixture
def client(config: Config, service: Service) -> FlaskClient:
    return create_app(config, service).test_client()


def upload(client: FlaskClient, torso: bytes) -> str:
    answer = client.post("/api/scans", data={"file": (io.BytesIO(torso), "torso.ply")})
    assert answer.json is not None
    return answer.json["id"]


def not_removed(client: FlaskClient) -> str:
    lines = client.get("/metrics").get_data(as_text=True).splitlines()
    return next(line.removeprefix(LEFT) for line in lines if line.startswith(LEFT))


def test_a_deletion_that_leaves_files_says_so_and_is_made_up_for(
    client: FlaskClient, service: Service, torso: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    scan = upload(client, torso)
    fit = client.post("/api/fits", json={"scan": scan, "drawing": None}).json["id"]
    ended(service, fit)
    unlink = os.unlink

    def refuse(path: str, **more: int) -> None:
        if path == "fitted.glb":
            raise PermissionError(1, "Operation not permitted")
        unlink(path, **more)

    with monkeypatch.context() as patch:
        patch.setattr(os, "unlink", refuse)
        for _ in range(2):
            answer = client.delete(f"/api/scans/{scan}")
            assert answer.headers["Clear-Site-Data"] == '"cache"'
            sentence = problem(answer, 500)
            assert "1 of the folders with its files could not be removed" in sentence
        for place in (f"/api/scans/{scan}", f"/api/fits/{fit}", f"/api/fits/{fit}/fitted.glb"):
            assert client.get(place).status_code == 404
        assert not_removed(client) == "1.0"
        assert client.get("/readyz").status_code == 200
    assert [path.name for path in service.storage.root.rglob("*.glb")] == ["fitted.glb"]
    assert client.delete(f"/api/scans/{scan}").status_code == 204
    assert not_removed(client) == "0.0"
    assert not of_patients(service.storage.root)


def test_files_that_could_not_be_removed_are_tried_again_from_time_to_time(
    config: Config, torso: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("NEWS_EVERY_S", "RETRY_EVERY_S"):
        monkeypatch.setattr(sweep, name, 0.05)
    service = Service(
        Storage(tmp_path / "data"), model=config.model, fits=FitLimits(workers=1, grace_s=0.1), keep_days=None
    )
    with service.started():
        client = create_app(config, service).test_client()
        scan = upload(client, torso)
        with monkeypatch.context() as patch:
            patch.setattr(os, "rmdir", lambda *_path, **_more: (_ for _ in ()).throw(PermissionError(1, "no")))
            problem(client.delete(f"/api/scans/{scan}"), 500)
            assert list((service.storage.root / "rubbish").iterdir())
        until(lambda: not list((service.storage.root / "rubbish").iterdir()), "another attempt")
        assert client.delete(f"/api/scans/{scan}").status_code == 204


@pytest.mark.slow
@pytest.mark.parametrize("damage", ["emptied", "cut to nothing"])
def test_an_index_that_is_lost_under_a_running_service_is_made_again_and_no_case_is_missed(
    damage: str, client: FlaskClient, service: Service, torso: bytes
) -> None:
    scan = upload(client, torso)
    file = current(service.storage.root)
    assert file is not None
    if damage == "cut to nothing":
        os.truncate(file, 0)
    else:
        other = file.with_name("empty")
        other.touch()
        other.rename(file)  # whoever has the old file open keeps it
    assert client.get(f"/api/scans/{scan}").status_code == 200
    assert client.get("/readyz").status_code == 200
    [patient] = client.get("/api/patients").json["patients"]
    assert [one["id"] for one in patient["scans"]] == [scan]
    remade = current(service.storage.root)
    assert remade is not None
    assert remade.stat().st_size > 0
