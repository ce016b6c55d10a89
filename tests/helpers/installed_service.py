"""A service on a cluster, with fits that need no numerics."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flask.testing import FlaskClient
from werkzeug.test import TestResponse

from breastrig.api.app import create_app
from breastrig.api.config import Config
from breastrig.execution.limits import FitLimits
from breastrig.service.service import Service
from breastrig.storage.storage import Storage
from breastrig.use.cases.case_work import Runner
from helpers import fake_fit, fake_proposals
from helpers.installations import Large


class Client(FlaskClient):
    """Reads every answer to its end and closes it."""

    def open(self, *args: Any, buffered: bool = True, **kwargs: Any) -> TestResponse:
        return super().open(*args, buffered=buffered, **kwargs)


@dataclass(frozen=True)
class Running:
    """A service at work."""

    service: Service
    client: FlaskClient
    root: Path
    installation: Large


@contextmanager
def serving(
    installation: Large, root: Path, model: Path, runner: Runner = fake_fit.mostly_patient
) -> Iterator[Running]:
    """A service on that place, which is left as it is at the end."""
    service = Service(
        Storage(root),
        runner=runner,
        proposer=fake_proposals.at_the_nipple,
        model=model,
        fits=FitLimits(workers=2, grace_s=0.1),
        executor=installation.executor(),
        keep_days=None,
    )
    with service.started():
        app = create_app(Config(model=model, heartbeat_s=0.05), service)
        app.test_client_class = Client
        yield Running(service, app.test_client(), root, installation)
