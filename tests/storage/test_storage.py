import os
from pathlib import Path

import pytest

from breastrig.cases.fits import claimed
from breastrig.core.errors import BadSettings
from breastrig.storage.data_folder import MARK
from breastrig.storage.deletion import delete_scan, finish_deletions
from breastrig.storage.storage import Storage, default_data_folder, utc_now


def test_a_second_server_on_the_same_folder_is_refused(storage: Storage) -> None:
    other = Storage(storage.root)
    with storage.exclusive(), pytest.raises(BadSettings, match="Another BreastRig server"), other.exclusive():
        pass
    with other.exclusive():
        pass
    other.close()


def test_only_the_owner_can_look_into_the_data_folder(storage: Storage, fit_id: str) -> None:
    found = [storage.root, *storage.root.rglob("*")]
    assert {path for path in found if path.stat().st_mode & 0o077} <= {storage.root / MARK}  # that is no secret


def test_a_prior_that_a_service_had_learned_does_not_outlive_its_patients(storage: Storage) -> None:
    learned = storage.root / "models" / "priors.json"
    learned.write_text('{"a model": "sums over patients"}')
    storage.prepare()
    assert learned.read_bytes() == b""
    storage.prepare()


def test_the_default_folder_follows_the_xdg_rules(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    assert default_data_folder() == tmp_path / "breastrig"
    monkeypatch.setenv("XDG_DATA_HOME", "not/absolute")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert default_data_folder() == tmp_path / ".local" / "share" / "breastrig"


def test_the_time_says_that_it_is_utc() -> None:
    assert utc_now().endswith("Z")
    assert len(utc_now()) == len("2026-01-01T00:00:00.000Z")


def test_deleting_a_scan_touches_nothing_else(storage: Storage, scan_id: str, tmp_path: Path) -> None:
    for folder in ("cases/a", "rubbish/a", "rubbish/scans.b", "incoming/a"):
        (storage.root / folder).mkdir()
        (storage.root / folder / "file").write_bytes(b"x")
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "file").write_bytes(b"x")
    (storage.files.scan(scan_id) / "link").symlink_to(tmp_path / "elsewhere")
    assert delete_scan(storage, scan_id) == []
    assert finish_deletions(storage) == []
    assert os.listdir(storage.root / "cases") == ["a"]
    assert sorted(os.listdir(storage.root / "rubbish")) == ["a", "scans.b"]
    assert os.listdir(storage.root / "incoming") == ["a"]
    assert (tmp_path / "elsewhere" / "file").read_bytes() == b"x"


def test_a_fit_that_a_process_is_at_is_waited_for(storage: Storage, scan_id: str, fit_id: str) -> None:
    case, _ = storage.case_of_fit(fit_id)
    with claimed(case, scan_id, fit_id):
        assert not storage.files.wait_until_free(fit_id, 0.02)
    assert storage.files.wait_until_free(fit_id, 0.02)
    assert delete_scan(storage, scan_id) == []
    assert storage.files.wait_until_free(fit_id, 0.02)
