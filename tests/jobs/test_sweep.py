from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from helpers import fake_fit
from helpers.on_disk import bytes_below
from helpers.rows import add_waiting_fit
from helpers.waiting import until

from breastrig.cli.main import main
from breastrig.jobs.limits import FitLimits
from breastrig.jobs.service import Service
from breastrig.storage.scans import ScanRow, add_scan, scan_ids
from breastrig.storage.storage import Storage, iso_utc

FACTS = {"unit": "mm", "bounds_m": {"min": [0, 0, 0], "max": [1, 1, 1]}}
AGES_DAYS = {"new": 0.0, "nearly": 29.9, "old": 30.1, "very_old": 400.0}


@pytest.fixture
def aged(storage: Storage) -> Storage:
    """Scans of several ages, each with a fit and files."""
    for scan_id, age in AGES_DAYS.items():
        storage.folders.make(storage.folders.scan(scan_id))
        storage.folders.uploaded(scan_id, "ply").write_bytes(f"skin of {scan_id}".encode())
        add_scan(storage, ScanRow(scan_id, iso_utc(datetime.now(UTC) - timedelta(days=age)), "ply", "ab" * 32, FACTS))
        storage.folders.make(storage.folders.fit(f"fit_of_{scan_id}"))
        (storage.folders.fit(f"fit_of_{scan_id}") / "result.json").write_text(f"result of {scan_id}")
        add_waiting_fit(storage, scan_id, f"fit_of_{scan_id}")
    return storage


def names_left(root: Path) -> str:
    """Everything that the data folder holds, as one text."""
    names = " ".join(path.as_posix() for path in root.rglob("*"))
    return names + bytes_below(root).decode("latin-1")


def test_a_running_server_deletes_what_is_older_than_it_keeps(aged: Storage) -> None:
    limits = FitLimits(workers=1, grace_s=0.2)
    service = Service(Storage(aged.root), runner=fake_fit.quick, fits=limits, keep_days=30)
    with service.started():
        until(lambda: scan_ids(aged) == {"new", "nearly"}, "the sweep")
        until(lambda: not list((aged.root / "rubbish").iterdir()), "the end of the sweep")
    for trace in ("very_old", "fit_of_old", "skin of old", "result of old"):
        assert trace not in names_left(aged.root)
    assert aged.folders.uploaded("new", "ply").is_file()


def test_a_server_that_keeps_forever_deletes_nothing(aged: Storage) -> None:
    service = Service(Storage(aged.root), runner=fake_fit.quick, fits=FitLimits(workers=1, grace_s=0.2), keep_days=None)
    assert service._sweep is None
    with service.started():
        assert scan_ids(aged) == set(AGES_DAYS)


def test_purge_deletes_the_older_ones_without_a_trace(aged: Storage, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["purge", "--older-than", "30", "--data", str(aged.root)]) == 0
    assert capsys.readouterr().out.startswith("2 scans deleted")
    assert scan_ids(aged) == {"new", "nearly"}
    left = names_left(aged.root)
    for trace in ("very_old", "fit_of_old", "skin of old", "result of old"):
        assert trace not in left
    assert "skin of new" in left


def test_purge_of_all_leaves_an_empty_data_folder(aged: Storage, capsys: pytest.CaptureFixture[str]) -> None:
    aged.close()
    assert main(["purge", "--all", "--data", str(aged.root)]) == 0
    assert capsys.readouterr().out.startswith("4 scans deleted")
    left = names_left(aged.root)
    for scan_id in AGES_DAYS:
        assert f"skin of {scan_id}" not in left
        assert f"fit_of_{scan_id}" not in left
    assert not list(aged.root.glob("*/*"))
    assert main(["purge", "--all", "--data", str(aged.root)]) == 0
    assert capsys.readouterr().out.startswith("0 scans deleted")


def test_purge_of_a_folder_that_is_none_or_is_held_by_a_server_says_so(
    aged: Storage, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["purge", "--all", "--data", str(tmp_path / "nothing")]) == 2
    assert "There is no BreastRig data folder" in capsys.readouterr().err
    assert not (tmp_path / "nothing").exists()
    with aged.exclusive():
        assert main(["purge", "--all", "--data", str(aged.root)]) == 2
    assert "Another BreastRig server uses" in capsys.readouterr().err
    assert scan_ids(aged) == set(AGES_DAYS)


@pytest.mark.parametrize(
    "options", [[], ["--older-than", "-1"], ["--older-than", "a week"], ["--all", "--older-than", "1"]]
)
def test_purge_asks_what_to_delete(options: list[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["purge", *options])
    assert stop.value.code == 2


@pytest.mark.parametrize("days", ["0", "-1", "often"])
def test_a_server_is_not_told_to_delete_at_once(days: str) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["serve", "--keep-days", days])
    assert stop.value.code == 2
