"""A case of a data folder with one scan, and one that stands alone."""

from pathlib import Path

import pytest
from helpers.cases import data_folder, new_case, new_scan

from breastrig.cases.case_folder import CaseFolder


@pytest.fixture
def cases(tmp_path: Path) -> Path:
    return data_folder(tmp_path / "data")


@pytest.fixture(params=["in a data folder", "alone"])
def case(request: pytest.FixtureRequest, cases: Path, tmp_path: Path) -> CaseFolder:
    return new_case(cases) if request.param == "in a data folder" else CaseFolder.create(tmp_path / "A case.of hers")


@pytest.fixture
def scan(case: CaseFolder) -> str:
    return new_scan(case)
