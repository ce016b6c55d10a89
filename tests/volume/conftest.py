"""The torso, and fits of the example patient, standing and supine."""

from pathlib import Path

import pytest
from helpers.example_fits import write_example_fits


@pytest.fixture(scope="session")
def fits(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fits")
    write_example_fits(folder)
    return folder
