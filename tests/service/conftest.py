"""A data folder, and services around it with runners of the test's choice."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path

import pytest
from helpers.fake_proposals import at_the_nipple

from breastrig.execution.limits import FitLimits, UploadLimits
from breastrig.service.scans.scan_search import Proposer
from breastrig.service.service import Service
from breastrig.storage.documents.scans import StoredScan, add_scan
from breastrig.storage.folders import new_id
from breastrig.storage.storage import Storage, utc_now
from breastrig.use.cases.case_work import Runner

FACTS = {"unit": "mm", "bounds_m": {"min": [0, 0, 0], "max": [1, 1, 1]}}
MakeService = Callable[..., AbstractContextManager[Service]]


@pytest.fixture
def storage(tmp_path: Path) -> Iterator[Storage]:
    storage = Storage(tmp_path / "data")
    storage.prepare()
    yield storage
    storage.close()


@pytest.fixture
def scan_id(storage: Storage) -> str:
    scan_id = new_id()
    storage.files.make(f"scans/{scan_id}")
    (storage.files.scan(scan_id) / "scan.ply").write_bytes(b"ply")
    add_scan(storage, StoredScan(scan_id, utc_now(), "ply", "ab" * 32, FACTS))
    return scan_id


@pytest.fixture
def serving(storage: Storage) -> MakeService:
    """`with serving(runner) as service:`, with two workers and short patience."""

    def make(
        runner: Runner,
        proposer: Proposer = at_the_nipple,
        uploads: UploadLimits | None = None,
        **limits: float,
    ) -> AbstractContextManager[Service]:
        fits = FitLimits(**{"workers": 2, "wall_s": 30.0, "grace_s": 0.2, **limits})
        service = Service(
            Storage(storage.root),
            runner=runner,
            proposer=proposer,
            uploads=uploads,
            fits=fits,
            keep_days=None,
        )
        return service.started()

    return make
