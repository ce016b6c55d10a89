"""Two stances fitted by one job: two fits, each with its own events, which end together."""

import pytest
from helpers import fake_fit
from helpers.rows import add_waiting_pair
from helpers.waiting import ended, stored_events, until

from breastrig.core.errors import NotFound
from breastrig.service.service import Service
from breastrig.storage.folders import new_id
from breastrig.storage.rows.events import append, events_after
from breastrig.storage.rows.fits import NewFit, claim_fit, get_fit
from breastrig.storage.rows.scans import ScanRow, add_scan
from breastrig.storage.storage import Storage, utc_now

pytestmark = pytest.mark.long

FACTS = {"unit": "mm", "bounds_m": {"min": [0, 0, 0], "max": [1, 1, 1]}}


@pytest.fixture
def other_scan(storage: Storage) -> str:
    scan_id = new_id()
    storage.files.make(f"scans/{scan_id}")
    add_scan(storage, ScanRow(scan_id, utc_now(), "ply", "cd" * 32, FACTS))
    return scan_id


def kinds(service: Service, fit_id: str) -> list[str]:
    return [event.kind for event in stored_events(service, fit_id)]


def ask_for_pair(service: Service, first: str, second: str) -> tuple[str, str]:
    leading = service.add_fit(NewFit(scan=first, landmarks_mm={}), NewFit(scan=second, landmarks_mm={}))
    partner = get_fit(service.storage, leading).partner
    assert partner is not None
    return leading, partner


def test_both_fits_are_recorded_by_one_job(serving, scan_id: str, other_scan: str) -> None:
    with serving(fake_fit.failing) as service:
        pair = ask_for_pair(service, scan_id, other_scan)
        for each, partner, scan in zip(pair, pair[::-1], (scan_id, other_scan), strict=True):
            assert kinds(service, each) == ["started", *["iterated"] * 4, "done"]
            fit = get_fit(service.storage, each)
            assert (fit.state, fit.partner, fit.scan) == ("done", partner, scan)
            assert (service.storage.files.fit(each) / "result.json").is_file()


def test_many_pairs_and_single_fits_all_run(serving, scan_id: str, other_scan: str) -> None:
    with serving(fake_fit.quick) as service:
        fits = [each for _ in range(4) for each in ask_for_pair(service, scan_id, other_scan)]
        fits += [service.add_fit(NewFit(scan=scan_id, landmarks_mm={})) for _ in range(3)]
        assert {ended(service, each).state for each in fits} == {"done"}


def test_what_befalls_one_befalls_both(serving, scan_id: str, other_scan: str) -> None:
    with serving(fake_fit.quick, fake_fit.failing_pair) as service:
        for each in ask_for_pair(service, scan_id, other_scan):
            assert ended(service, each).reason == "The model found no skin near it; place three landmarks."


def test_a_result_that_was_finished_is_kept_when_the_process_dies_on_the_other(
    serving, scan_id: str, other_scan: str
) -> None:
    with serving(fake_fit.quick, fake_fit.half_dying_pair) as service:
        first, second = ask_for_pair(service, scan_id, other_scan)
        assert ended(service, second).state == "failed"
        assert get_fit(service.storage, first).state == "done"


@pytest.mark.parametrize("which", [0, 1])
def test_cancelling_one_cancels_both_and_kills_the_process(serving, scan_id: str, other_scan: str, which: int) -> None:
    with serving(fake_fit.quick, fake_fit.patient_pair) as service:
        pair = ask_for_pair(service, scan_id, other_scan)
        until(lambda: get_fit(service.storage, pair[1]).iterations > 1, "some iterations")
        assert service.cancel_fit(pair[which]).state == "cancelled"
        for each in pair:
            assert get_fit(service.storage, each).state == "cancelled"
            assert events_after(service.storage, each, 0)[-1].kind == "cancelled"
            assert service.storage.files.wait_until_free(each, 5.0)


@pytest.mark.slow
@pytest.mark.parametrize("which", [0, 1])
def test_deleting_one_scan_stops_the_pair_and_leaves_no_trace_of_it_at_the_other(
    serving, scan_id: str, other_scan: str, which: int
) -> None:
    with serving(fake_fit.quick, fake_fit.patient_pair) as service:
        pair = ask_for_pair(service, scan_id, other_scan)
        until(lambda: get_fit(service.storage, pair[1]).iterations > 1, "some iterations")
        service.delete_scan((scan_id, other_scan)[which])
        with pytest.raises(NotFound):
            get_fit(service.storage, pair[which])
        left = get_fit(service.storage, pair[1 - which])
        assert (left.state, left.reason, left.partner) == ("cancelled", "The other stance's scan was deleted.", None)
        assert service.storage.files.wait_until_free(left.id, 5.0)


def test_deleting_one_scan_keeps_the_others_finished_result(serving, scan_id: str, other_scan: str) -> None:
    with serving(fake_fit.quick) as service:
        pair = ask_for_pair(service, scan_id, other_scan)
        for each in pair:
            ended(service, each)
        service.delete_scan(scan_id)
        left = get_fit(service.storage, pair[1])
        assert (left.state, left.partner) == ("done", None)
        assert kinds(service, pair[1])[-1] == "done"


def test_after_a_restart_waiting_and_running_pairs_come_to_their_ends(
    serving, storage: Storage, scan_id: str, other_scan: str
) -> None:
    interrupted, waiting = ("a", "b"), ("c", "d")
    for pair in (interrupted, waiting):
        for each in pair:
            storage.files.make(f"fits/{each}")
        add_waiting_pair(storage, scan_id, other_scan, pair)
    claimed = claim_fit(storage, "a")
    assert claimed is not None
    assert claimed.both == interrupted
    assert get_fit(storage, "b").state == "running"
    append(storage, "a", {"kind": "started", "stance": "standing", "model_sha256": "0" * 64})
    with serving(fake_fit.quick) as service:
        for each in (*waiting, *interrupted):
            assert kinds(service, each) == ["started", *["iterated"] * 4, "done"]
            assert get_fit(service.storage, each).attempt == (1 if each in waiting else 2)


@pytest.mark.parametrize("done", [0, 1])
def test_after_a_restart_the_partner_of_a_finished_fit_is_finished_and_the_finished_one_stays_as_it_is(
    serving, storage: Storage, scan_id: str, other_scan: str, done: int
) -> None:
    pair = ("a", "b")
    for each in pair:
        storage.files.make(f"fits/{each}")
    add_waiting_pair(storage, scan_id, other_scan, pair)
    claim_fit(storage, "a")
    (storage.files.fit(pair[done]) / "result.json").write_text("as it was")
    append(storage, pair[done], {"kind": "done", "result": {}})
    with serving(fake_fit.quick) as service:
        assert [event.kind for event in stored_events(service, pair[1 - done])] == [
            "started",
            *["iterated"] * 4,
            "done",
        ]
        assert kinds(service, pair[done]) == ["done"]
        assert (storage.files.fit(pair[done]) / "result.json").read_text() == "as it was"
        assert (storage.files.fit(pair[1 - done]) / "result.json").is_file()
