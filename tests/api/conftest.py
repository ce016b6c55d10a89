"""A service with fits that need no numerics, the toy rig as its model, the toy torso as its example."""

import io
import json
import os
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from apiflask import APIFlask
from flask.testing import FlaskClient
from helpers import fake_fit, fake_proposals
from helpers.remembered_uploads import remembering_uploads
from helpers.toy_rig import toy_rig
from helpers.uploads import torso as torso_ply
from werkzeug.security import generate_password_hash
from werkzeug.test import TestResponse

from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.api.routes.shares import shares
from breastrig.execution.limits import FitLimits
from breastrig.service.service import Service
from breastrig.storage.storage import Storage
from breastrig_studies.output.rig_files import write_rig

NIPPLE_MM = [70.0, 350.0, 120.0]
ROUTES = pytest.StashKey[list[str]]()


class Client(FlaskClient):
    """Reads every answer to its end and closes it, unless told otherwise."""

    def open(self, *args: Any, buffered: bool = True, **kwargs: Any) -> TestResponse:
        return super().open(*args, buffered=buffered, **kwargs)


@pytest.fixture(scope="module", autouse=True)
def no_upload_read_twice() -> Iterator[None]:
    with remembering_uploads():
        yield


@pytest.fixture(scope="module", autouse=True)
def quick_passcodes() -> Iterator[None]:
    """Hashes of passcodes with little work, by which they are checked as well."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shares, "generate_password_hash", partial(generate_password_hash, method="scrypt:256:8:1"))
        yield


@pytest.fixture(scope="session")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("model")
    write_rig(toy_rig(), folder)
    return folder / "toy.glb"


@pytest.fixture(scope="session")
def examples(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("example")
    (folder / "standing").mkdir()
    (folder / "standing" / "scan.ply").write_bytes(torso_ply())
    (folder / "standing" / "case.json").write_text(json.dumps({"stance": "standing"}))
    landmarks = {"schema": "breastrig/landmarks@1", "unit": "mm", "landmarks": {"nipple_L": NIPPLE_MM}}
    (folder / "standing" / "landmarks.json").write_text(json.dumps(landmarks))
    return folder


@pytest.fixture(scope="session")
def web(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("web")
    (folder / "assets").mkdir()
    (folder / "index.html").write_text("<!doctype html><title>the page</title>")
    (folder / "assets" / "index-abc123.js").write_text("export {};")
    return folder


@pytest.fixture(scope="session")
def config(model: Path, examples: Path, web: Path) -> Config:
    return Config(model=model, examples=examples, web=web, heartbeat_s=0.05)


@pytest.fixture(scope="session")
def service(tmp_path_factory: pytest.TempPathFactory, config: Config) -> Iterator[Service]:
    storage = Storage(tmp_path_factory.mktemp("data"))
    limits = FitLimits(workers=2, grace_s=0.1)
    service = Service(
        storage,
        runner=fake_fit.mostly_patient,
        proposer=fake_proposals.at_the_nipple,
        model=config.model,
        examples=config.examples,
        fits=limits,
    )
    with service.started():
        yield service


@pytest.fixture
def lose_index(service: Service) -> Iterator[Callable[[], None]]:
    """As when somebody removes the files of the index; sessions of before it are good again at the end of the test."""

    def lose() -> None:
        for file in service.storage.root.glob("index-*"):
            file.unlink(missing_ok=True)

    yield lose
    with service.storage.index.writing() as rows:
        rows.execute("DELETE FROM meta WHERE key = 'sessions_from'")


@pytest.fixture(scope="session")
def app(config: Config, service: Service) -> APIFlask:
    return testable(create_app(config, service))


def testable(app: APIFlask) -> APIFlask:
    app.test_client_class = Client
    return app


@pytest.fixture(scope="session")
def client_for(service: Service) -> Callable[[Config], FlaskClient]:
    """A client of another application around the same service."""
    return lambda config: testable(create_app(config, service)).test_client()


@pytest.fixture
def client(app: APIFlask) -> FlaskClient:
    return app.test_client()


@pytest.fixture(scope="session")
def torso() -> bytes:
    return torso_ply()


@pytest.fixture
def scan_id(client: FlaskClient, torso: bytes) -> Iterator[str]:
    """An uploaded scan, deleted at the end."""
    answer = client.post("/api/scans", data={"file": (io.BytesIO(torso), "torso.ply")})
    assert answer.status_code == 201, answer.json
    assert answer.json is not None
    scan_id = answer.json["id"]
    yield scan_id
    client.delete(f"/api/scans/{scan_id}")


@pytest.fixture
def fit_id(client: FlaskClient, service: Service, scan_id: str) -> str:
    """A fit that is done."""
    from helpers.waiting import ended

    answer = client.post("/api/fits", json={"scan": scan_id, "drawing": "lumpectomy"})
    assert answer.status_code == 202, answer.json
    assert answer.json is not None
    assert ended(service, answer.json["id"]).state == "done"
    return answer.json["id"]


@pytest.fixture
def keep_route_table(request: pytest.FixtureRequest) -> Callable[[list[str]], None]:
    """Keeps the lines of the table for the end of the run."""

    def keep(lines: list[str]) -> None:
        request.config.stash[ROUTES] = lines

    return keep


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    lines = config.stash.get(ROUTES, [])
    if os.environ.get("BREASTRIG_ROUTE_TABLE") and lines:
        terminalreporter.section("routes")
        for line in lines:
            terminalreporter.write_line(line)
