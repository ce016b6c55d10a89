"""A prepared data folder with one scan and one waiting fit."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.rows import add_waiting_fit

from breastrig.storage.rows.scans import ScanRow, add_scan
from breastrig.storage.storage import Storage

FACTS = {"unit": "mm", "bounds_m": {"min": [0, 0, 0], "max": [1, 1, 1]}}


@pytest.fixture
def storage(tmp_path: Path) -> Iterator[Storage]:
    storage = Storage(tmp_path / "data")
    storage.prepare()
    yield storage
    storage.close()


@pytest.fixture
def scan_id(storage: Storage) -> str:
    storage.files.make("scans/scan-1")
    add_scan(storage, ScanRow("scan-1", "2026-01-01T00:00:00.000Z", "ply", "ab" * 32, FACTS))
    return "scan-1"


@pytest.fixture
def fit_id(storage: Storage, scan_id: str) -> str:
    add_waiting_fit(storage, scan_id, "fit-1")
    return "fit-1"
