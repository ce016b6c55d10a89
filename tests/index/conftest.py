"""A data folder with three cases, and its index."""

import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from helpers.cases import data_folder, new_case, new_fit, new_scan, note

from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.plans import put_plan
from breastrig.index.index import Index


@pytest.fixture
def root(tmp_path: Path) -> Path:
    return tmp_path / "data"


@pytest.fixture
def cases(root: Path) -> dict[str, CaseFolder]:
    """By their codes."""
    place = data_folder(root)
    found = {}
    for code in ("P 2", "P 10", "Ärztin"):
        found[code] = new_case(place, code)
        time.sleep(0.002)  # so that each has a millisecond of its own: those of one are listed by their random ids
    for case in found.values():
        scan = new_scan(case)
        new_fit(case, scan)
        put_plan(case, [note(scan)])
    return found


@pytest.fixture
def index(root: Path, cases: dict[str, CaseFolder]) -> Iterator[Index]:
    index = Index(root)
    index.prepare()
    yield index
    index.close()
