"""The process that has read an upload serves this scan alone, until the scan is deleted."""

import os
from pathlib import Path

import pytest
from helpers import fake_fit, fake_proposals
from helpers.remembered_uploads import read_upload_once
from helpers.waiting import ask_for_fit, ended, until

from breastrig.core.assets import asset_folder
from breastrig.service.scans import uploads
from breastrig.service.service import Service
from breastrig.storage.documents.fits import get_fit
from breastrig.storage.documents.scans import StoredScan

pytestmark = pytest.mark.long

STANCES = ("standing", "supine")


@pytest.fixture(autouse=True)
def read_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """What was read before is not computed again, though a process is asked for it."""
    monkeypatch.setattr(uploads, "read_upload", read_upload_once)


def uploaded(service: Service, stance: str) -> StoredScan:
    with (asset_folder("example") / stance / "scan.ply").open("rb") as source:
        row, _ = service.uploads.add(source, "ply", "auto")
    assert row.id in service.pool.idle_keys
    return row


def process_of(service: Service, scan: StoredScan) -> int:
    return int(service.pool.queue(1, 2**32).result(os.getpid, (), 30.0, scan.id))


def proposing_process(service: Service, scan: StoredScan) -> int:
    found = service.proposals.of(scan, "a" * 64, 60.0)
    assert found is not None
    return int(found["nipple_L"]["reason"])


def is_alive(pid: int) -> bool:
    return Path(f"/proc/{pid}").exists()


@pytest.mark.slow
def test_each_scan_is_proposed_on_where_it_was_read_and_no_other_scan_is(serving) -> None:
    with serving(fake_fit.quick, proposer=fake_proposals.by_process) as service:
        scans = [uploaded(service, stance) for stance in STANCES]
        readers = [process_of(service, scan) for scan in scans]
        assert readers[0] != readers[1]
        assert [proposing_process(service, scan) for scan in scans] == readers


@pytest.mark.slow
def test_a_fit_runs_where_its_scan_was_read(serving) -> None:
    with serving(fake_fit.by_process) as service:
        scans = [uploaded(service, stance) for stance in STANCES]
        for scan in scans:
            reader = process_of(service, scan)
            assert ended(service, ask_for_fit(service, scan.id)).reason == f"process {reader}"


@pytest.mark.slow
def test_deleting_a_scan_ends_its_process_and_leaves_the_other_one(serving) -> None:
    with serving(fake_fit.quick) as service:
        first, second = (uploaded(service, stance) for stance in STANCES)
        gone, stays = process_of(service, first), process_of(service, second)
        service.delete_scan(first.id)
        assert not is_alive(gone)
        assert process_of(service, second) == stays


def test_deleting_a_scan_ends_the_fit_that_runs_in_its_process(serving) -> None:
    with serving(fake_fit.hanging) as service:
        scan = uploaded(service, "standing")
        reader = process_of(service, scan)
        ask_for_fit(service, scan.id)
        until(lambda: scan.id not in service.pool.idle_keys, "the fit in the scan's process")
        service.delete_scan(scan.id)
        assert not is_alive(reader)


@pytest.mark.slow
def test_a_cancelled_fit_takes_its_process_along_and_the_next_one_starts_elsewhere(serving) -> None:
    with serving(fake_fit.hanging) as service:
        scan = uploaded(service, "standing")
        reader = process_of(service, scan)
        fit = ask_for_fit(service, scan.id)
        until(lambda: get_fit(service.storage, fit).state == "running", "a fit that hangs in the scan's process")
        assert service.cancel_fit(fit).state == "cancelled"
        until(lambda: not is_alive(reader), "the end of the process")
        again = ask_for_fit(service, scan.id)
        assert service.pool.idle_keys == []
        service.cancel_fit(again)


def test_a_stopped_service_leaves_no_process(serving) -> None:
    with serving(fake_fit.quick) as service:
        reader = process_of(service, uploaded(service, "standing"))
    assert not is_alive(reader)
