"""A prepared data folder with one scan and one waiting fit."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.stored_fits import add_waiting_fit, named

from breastrig.storage.documents.scans import StoredScan, add_scan
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
    scan_id = named("scan-1")
    storage.files.make(f"scans/{scan_id}")
    add_scan(storage, StoredScan(scan_id, "2026-01-01T00:00:00.000Z", "ply", "ab" * 32, FACTS))
    return scan_id


@pytest.fixture
def fit_id(storage: Storage, scan_id: str) -> str:
    add_waiting_fit(storage, scan_id, named("fit-1"))
    return named("fit-1")
