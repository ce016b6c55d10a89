import os
from pathlib import Path

import pytest

from breastrig.core.errors import BadSettings
from breastrig.storage.storage import Storage, default_data_folder, utc_now


def test_a_second_server_on_the_same_folder_is_refused(storage: Storage) -> None:
    other = Storage(storage.root)
    with storage.exclusive(), pytest.raises(BadSettings, match="Another BreastRig server"), other.exclusive():
        pass
    with other.exclusive():
        pass
    other.close()


def test_a_folder_that_cannot_be_made_gives_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    storage = Storage(tmp_path / "file" / "data")
    with pytest.raises(BadSettings, match="cannot be created"):
        storage.prepare()


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


def test_removing_a_folder_touches_nothing_else(storage: Storage, tmp_path: Path) -> None:
    for folder in ("scans/a", "scans/b", "fits/a", "rubbish/a", "rubbish/scans.b"):
        (storage.root / folder).mkdir()
        (storage.root / folder / "file").write_bytes(b"x")
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "file").write_bytes(b"x")
    (storage.root / "scans" / "a" / "link").symlink_to(tmp_path / "elsewhere")
    (storage.root / "fits" / "link").symlink_to(tmp_path / "elsewhere")
    assert storage.remove("scans/a", "fits/link", "fits/nobody") == []
    assert os.listdir(storage.root / "scans") == ["b"]
    assert os.listdir(storage.root / "fits") == ["a"]
    assert sorted(os.listdir(storage.root / "rubbish")) == ["a", "scans.b"]
    assert (tmp_path / "elsewhere" / "file").read_bytes() == b"x"


def test_a_folder_that_a_process_writes_into_is_waited_for(storage: Storage) -> None:
    folders = storage.files
    folders.make("fits/busy")
    with folders.held("busy"):
        assert not folders.wait_until_free("busy", 0.02)
    assert folders.wait_until_free("busy", 0.02)
    folders.remove("fits/busy")
    assert folders.wait_until_free("busy", 0.02)
    with pytest.raises(FileNotFoundError), folders.held("busy"):
        pass
