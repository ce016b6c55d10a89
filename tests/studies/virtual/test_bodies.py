"""Files that are no virtual cohort are refused with a sentence."""

import shutil
from pathlib import Path

import pytest

from breastrig.core.errors import BadInput
from breastrig_studies.virtual.bodies import cohort_folder, read_bodies


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    for name in ("bodies.npz", "patients.json"):
        shutil.copy(cohort_folder() / name, tmp_path)
    return tmp_path


def test_a_copy_is_read_as_the_original(copied: Path) -> None:
    assert read_bodies(copied).sha256 == read_bodies().sha256


@pytest.mark.parametrize("missing", ["bodies.npz", "patients.json"])
def test_a_missing_file_is_named(copied: Path, missing: str) -> None:
    (copied / missing).unlink()
    with pytest.raises(BadInput, match=missing):
        read_bodies(copied)
