from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from helpers import fake_fit
from helpers.on_disk import kept_below, of_patients
from helpers.stored_fits import add_waiting_fit, named, scan_ids
from helpers.waiting import until

from breastrig.cases.case_folder import CaseFolder
from breastrig.cases.layout import CASES
from breastrig.cli.main import main
from breastrig.core import wall_clock
from breastrig.execution.limits import FitLimits
from breastrig.index.index import Index
from breastrig.index.questions import aged_scans
from breastrig.service import sweep
from breastrig.service.service import Service
from breastrig.service.sweep import Retention, Sweep
from breastrig.storage.documents.expiring_scans import announce
from breastrig.storage.documents.patients import listed_page
from breastrig.storage.documents.scans import StoredScan, add_scan
from breastrig.storage.storage import Storage, iso_utc

FACTS = {"unit": "mm", "bounds_m": {"min": [0, 0, 0], "max": [1, 1, 1]}}
NEW, NEARLY, OLD, VERY_OLD = (named(name) for name in ("new", "nearly", "old", "very_old"))
AGES_DAYS = {NEW: 0.0, NEARLY: 29.9, OLD: 30.1, VERY_OLD: 400.0}


@pytest.fixture
def aged(storage: Storage) -> Storage:
    """Scans of several ages, each with a fit and files."""
    for scan_id, age in AGES_DAYS.items():
        storage.files.make(f"scans/{scan_id}")
        (storage.files.scan(scan_id) / "scan.ply").write_bytes(f"skin of {scan_id}".encode())
        add_scan(
            storage, StoredScan(scan_id, iso_utc(datetime.now(UTC) - timedelta(days=age)), "ply", "ab" * 32, FACTS)
        )
        fit_id = named(f"of_{scan_id[:9]}")
        storage.files.make(f"fits/{fit_id}")
        (storage.files.fit(fit_id) / "result.json").write_text(f"result of {scan_id}")
        add_waiting_fit(storage, scan_id, fit_id)
    return storage


class Clock:
    """Stands in for the clock and the uptime of the machine."""

    def __init__(self) -> None:
        self.now = datetime(2026, 3, 1, tzinfo=UTC)
        self.uptime_s = 1e5

    def run(self, **time: float) -> None:
        """Time passes."""
        self.now += timedelta(**time)
        self.uptime_s += timedelta(**time).total_seconds()

    def jump(self, **time: float) -> None:
        """Somebody sets the clock."""
        self.now += timedelta(**time)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(wall_clock, "now", lambda: clock.now)
    monkeypatch.setattr(wall_clock, "uptime_s", lambda: clock.uptime_s)
    return clock


@pytest.fixture
def upload(storage: Storage, clock: Clock) -> Callable[[str], None]:
    return lambda name: add_scan(storage, StoredScan(named(name), iso_utc(clock.now), "ply", "ab" * 32, FACTS))


def test_a_scan_is_deleted_when_its_time_is_over_and_not_an_hour_before(
    storage: Storage, clock: Clock, upload: Callable[[str], None], caplog: pytest.LogCaptureFixture
) -> None:
    upload("scan")
    day = iso_utc(clock.now + timedelta(days=30))
    server = Retention(storage, 30)
    due = []
    for _ in range(24 * 30 + 1):
        due.append(server.due())
        clock.run(hours=1)
    assert due == [[]] * 24 * 30 + [[named("scan")]]
    assert [record.getMessage() for record in caplog.records] == [
        f"1 scans are older than 30 days or soon will be; if the clock is right, they are deleted from {day} on"
    ]


def test_starts_with_a_clock_that_is_40_days_ahead_delete_nothing(
    storage: Storage, clock: Clock, upload: Callable[[str], None]
) -> None:
    for name in ("older", "newer"):
        upload(name)
        clock.run(days=5)
    for _ in range(3):
        clock.jump(days=40)
        server = Retention(storage, 30)
        for _ in range(23):
            assert server.due() == []
            clock.run(hours=1)
        clock.jump(days=-40)
        server = Retention(storage, 30)
        assert server.due() == []
        assert [scan for scan in storage.index.asked(aged_scans, "0") if scan.announced_at] == []


def test_a_clock_that_jumps_while_the_server_runs_deletes_nothing_however_often(
    storage: Storage, clock: Clock, upload: Callable[[str], None], caplog: pytest.LogCaptureFixture
) -> None:
    upload("scan")
    server = Retention(storage, 30)
    for _ in range(10):
        assert server.due() == []
        clock.jump(days=40)
        clock.run(hours=2)
    clock.jump(days=-400)
    assert server.due() == []
    assert caplog.records[-1].getMessage() == "1 scans are not as old as the clock said before; they are kept"


def test_what_grew_old_while_no_server_ran_is_deleted_a_day_after_its_start_and_that_is_said(
    storage: Storage, clock: Clock, upload: Callable[[str], None], caplog: pytest.LogCaptureFixture
) -> None:
    upload("scan")
    clock.run(days=40)
    day = iso_utc(clock.now + timedelta(days=1))
    server = Retention(storage, 30)
    for _ in range(24):
        assert server.due() == []
        clock.run(hours=1)
    assert server.due() == [named("scan")]
    assert f"they are deleted from {day} on" in caplog.text


def test_a_server_that_never_runs_for_a_day_deletes_too(
    storage: Storage, clock: Clock, upload: Callable[[str], None]
) -> None:
    upload("scan")
    due = []
    for _ in range(7):
        server = Retention(storage, 30)
        due.append(server.due())
        clock.run(hours=1)
        due.append(server.due())
        clock.run(days=7)
    assert due == [[]] * 12 + [[named("scan")]] * 2  # announced after 35 days, deleted a week later


def test_a_clock_that_begins_before_the_upload_neither_deletes_nor_withdraws(
    storage: Storage, clock: Clock, upload: Callable[[str], None]
) -> None:
    """Of a machine without a battery, which asks the network for the time."""
    upload("scan")
    clock.run(days=29.5)
    assert Retention(storage, 30).due() == []
    clock.run(days=2)
    right = clock.now
    clock.now = datetime(1970, 1, 1, tzinfo=UTC)
    server = Retention(storage, 30)
    assert server.due() == []
    clock.now = right
    assert server.due() == [named("scan")]


def test_a_time_shorter_than_a_day_is_kept_too(storage: Storage, clock: Clock, upload: Callable[[str], None]) -> None:
    upload("scan")
    server = Retention(storage, 0.25)
    due = []
    for _ in range(7):
        due.append(server.due())
        clock.run(hours=1)
    assert due == [[]] * 6 + [[named("scan")]]


def test_a_running_server_deletes_what_is_older_than_it_keeps(aged: Storage) -> None:
    limits = FitLimits(workers=1, grace_s=0.2)
    announce(aged, [NEARLY, OLD, VERY_OLD], iso_utc(datetime.now(UTC) - timedelta(days=1)))
    service = Service(Storage(aged.root), runner=fake_fit.quick, fits=limits, keep_days=30)
    with service.started():
        until(lambda: scan_ids(aged) == {NEW, NEARLY}, "the sweep")
        until(lambda: not list((aged.root / "rubbish").iterdir()), "the end of the sweep")
    for trace in (VERY_OLD, "of_old", "skin of old", "result of old"):
        assert trace not in kept_below(aged.root).decode("latin-1")
    assert (aged.files.scan(NEW) / "scan.ply").is_file()


def test_a_running_server_sees_what_other_programs_write(aged: Storage, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweep, "NEWS_EVERY_S", 0.02)
    service = Service(aged, runner=fake_fit.quick, fits=FitLimits(workers=1, grace_s=0.2), keep_days=None)
    with service.started():
        case = CaseFolder.create(aged.root / CASES / named("another"), "K7M-4QX")
        until(lambda: "K7M-4QX" in {row.code for row in listed_page(aged, 9, None)[0]}, "another program's case")
        case.rename("L8N-5RY")
        until(lambda: "L8N-5RY" in {row.code for row in listed_page(aged, 9, None)[0]}, "its other code")


def test_a_server_that_keeps_forever_deletes_nothing(aged: Storage) -> None:
    service = Service(Storage(aged.root), runner=fake_fit.quick, fits=FitLimits(workers=1, grace_s=0.2), keep_days=None)
    announce(aged, AGES_DAYS, iso_utc(datetime.now(UTC) - timedelta(days=1)))
    with service.started():
        assert scan_ids(aged) == set(AGES_DAYS)
    deleted: list[str] = []
    sweeping = Sweep(aged, deleted.append, None)
    sweeping.start()
    sweeping.stop()  # it has looked once by then
    assert deleted == []


def test_purge_deletes_the_older_ones_without_a_trace(aged: Storage, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["purge", "--older-than", "30", "--data", str(aged.root)]) == 0
    assert capsys.readouterr().out.startswith("2 scans deleted")
    assert scan_ids(aged) == {NEW, NEARLY}
    left = kept_below(aged.root).decode("latin-1")
    for trace in (VERY_OLD, "of_old", "skin of old", "result of old"):
        assert trace not in left
    assert "skin of new" in left


def test_purge_of_all_leaves_an_empty_data_folder(aged: Storage, capsys: pytest.CaptureFixture[str]) -> None:
    aged.close()
    assert main(["purge", "--all", "--data", str(aged.root)]) == 0
    assert capsys.readouterr().out.startswith("4 scans deleted")
    left = kept_below(aged.root).decode("latin-1")
    for scan_id in AGES_DAYS:
        assert f"skin of {scan_id}" not in left
        assert f"of_{scan_id[:9]}" not in left
    assert not of_patients(aged.root)
    assert main(["purge", "--all", "--data", str(aged.root)]) == 0
    assert capsys.readouterr().out.startswith("0 scans deleted")


def test_purge_needs_no_index_and_names_the_cases_that_it_cannot_read(
    aged: Storage, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    damaged = aged.files.scan(VERY_OLD)
    (damaged / "scan.json").write_text("{")
    aged.close()

    def full(_index: Index) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(Index, "prepare", full)
        assert main(["purge", "--older-than", "30", "--data", str(aged.root)]) == 1
    said = capsys.readouterr()
    assert said.out.startswith("1 scan deleted")
    assert f"{damaged.parents[1]}: " in said.err
    assert "(No space left on device); make room" in said.err
    assert "What is deleted is named in the index until the next start." in said.err
    assert main(["purge", "--all", "--data", str(aged.root)]) == 0  # the damaged one too
    assert capsys.readouterr().out.startswith("3 scans deleted")
    left = kept_below(aged.root).decode("latin-1")
    assert not [scan for scan in AGES_DAYS if f"skin of {scan}" in left or scan in left]


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
def test_no_server_is_set_to_delete_at_once(days: str) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["serve", "--keep-days", days])
    assert stop.value.code == 2
