import json
import os
from pathlib import Path

import pytest
from helpers import fake_fit
from helpers.on_disk import bytes_below
from helpers.stored_fits import add_waiting_fit, append, named
from helpers.waiting import ask_for_fit, ended, stored_events, until

from breastrig.cases.fits import OTHER_MODEL, TOO_OFTEN, claimed, find_fit
from breastrig.core.errors import NotFound
from breastrig.service.fits import queue
from breastrig.service.fits.fit_worker import UNSEEN
from breastrig.storage.documents.events import events_after
from breastrig.storage.documents.fits import get_fit
from breastrig.storage.documents.scans import get_scan
from breastrig.storage.storage import Storage
from breastrig.use.cases.case_work import job_of
from breastrig.use.steps.events import event_json
from breastrig.use.steps.settings import FitJob

pytestmark = pytest.mark.long


def test_a_fit_stores_its_events_in_order_and_leaves_its_files(serving, scan_id: str) -> None:
    with serving(fake_fit.quick) as service:
        fit_id = ask_for_fit(service, scan_id)
        events = stored_events(service, fit_id)
        assert [event.kind for event in events] == ["started", *["iterated"] * 4, "done"]
        assert [event.number for event in events] == [1, 2, 3, 4, 5, 6]
        assert get_fit(service.storage, fit_id).state == "done"
        assert (service.storage.files.fit(fit_id) / "result.json").is_file()
        assert stored_events(service, fit_id) == events
        assert stored_events(service, fit_id, after=4) == events[4:]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("runner", "sentence"),
    [
        (fake_fit.failing, "The model found no skin near it; place three landmarks."),
        (fake_fit.broken, "The fit broke for a reason inside BreastRig; the server's log says it."),
        (fake_fit.dying, "The fit's process ended unexpectedly"),
        (fake_fit.greedy, "The fit needed more memory than it may use"),
        (fake_fit.silent, "The fit ended without a result"),
    ],
)
def test_whatever_befalls_one_fit_is_said_and_the_next_one_runs(serving, scan_id: str, runner, sentence: str) -> None:
    with serving(runner) as service:
        for fit in [ask_for_fit(service, scan_id) for _ in range(3)]:  # more than there are workers
            row = ended(service, fit)
            assert row.state == "failed"
            assert row.reason is not None
            assert row.reason.startswith(sentence)


def test_a_fit_that_takes_too_long_is_stopped(serving, scan_id: str) -> None:
    with serving(fake_fit.hanging, wall_s=0.3) as service:
        fit = ended(service, ask_for_fit(service, scan_id))
        assert (fit.state, fit.reason) == ("failed", "The fit took longer than 0.3 s and was stopped.")


def test_cancelling_a_running_fit_kills_its_process(serving, scan_id: str) -> None:
    with serving(fake_fit.patient) as service:
        fit_id = ask_for_fit(service, scan_id)
        until(lambda: get_fit(service.storage, fit_id).iterations > 1, "some iterations")
        assert service.cancel_fit(fit_id).state == "cancelled"
        assert service.storage.files.wait_until_free(fit_id, 5.0)
        events = events_after(service.storage, fit_id, 0)
        assert events[-1].kind == "cancelled"
        assert service.cancel_fit(fit_id).state == "cancelled"


@pytest.mark.slow
def test_cancelling_a_waiting_fit_means_that_it_never_runs(serving, scan_id: str) -> None:
    with serving(fake_fit.mostly_patient, workers=1) as service:
        running = ask_for_fit(service, scan_id, "paper")
        waiting = ask_for_fit(service, scan_id)
        last = ask_for_fit(service, scan_id)
        service.cancel_fit(waiting)
        service.cancel_fit(running)
        assert ended(service, last).state == "done"
        assert [event.kind for event in events_after(service.storage, waiting, 0)] == ["cancelled"]


KINDS = ["started", *["iterated"] * 4, "done"]


def begun(storage: Storage, scan_id: str, fit_id: str, events: int, attempts: int = 1) -> None:
    """A fit of fake_fit.quick that was left after so many events of its own."""
    add_waiting_fit(storage, scan_id, fit_id)
    stored = [fake_fit.started(FitJob(Path(), Path(), {})), *(fake_fit.iterated(k) for k in range(4))]
    case, _ = storage.case_of_fit(fit_id)
    for attempt in range(attempts):
        with claimed(case, scan_id, fit_id) as claim:
            assert claim is not None
            for event in stored[:events] if attempt == 0 else ():
                claim.append(event_json(event))
    storage.index.refresh(case.id)


@pytest.mark.slow
@pytest.mark.parametrize("stored", [0, 2, 5])
def test_after_a_restart_a_fit_goes_on_with_its_events_where_it_stopped(
    serving, storage: Storage, scan_id: str, stored: int
) -> None:
    begun(storage, scan_id, named("interrupted"), stored)
    before = events_after(storage, named("interrupted"), 0)
    with serving(fake_fit.quick) as service:
        events = stored_events(service, named("interrupted"))
        assert events[:stored] == before
        assert [event.kind for event in events] == KINDS
        assert [event.number for event in events] == [1, 2, 3, 4, 5, 6]
        assert [json.loads(event.json)["iteration"] for event in events[1:-1]] == [0, 1, 2, 3]
        fit = get_fit(service.storage, named("interrupted"))
        assert (fit.state, fit.attempt, fit.iterations) == ("done", 2, 4)
        assert (service.storage.files.fit(named("interrupted")) / "result.json").is_file()


def test_after_a_restart_what_ran_comes_before_what_waited(serving, storage: Storage, scan_id: str) -> None:
    begun(storage, scan_id, named("interrupted"), 2)
    add_waiting_fit(storage, scan_id, named("waiting"))
    with serving(fake_fit.quick, workers=1) as service:
        assert ended(service, named("waiting")).state == "done"
        assert get_fit(service.storage, named("interrupted")).state == "done"


def test_a_fit_is_started_three_times_and_then_fails(serving, storage: Storage, scan_id: str) -> None:
    begun(storage, scan_id, named("twice"), 2, attempts=2)
    begun(storage, scan_id, named("thrice"), 2, attempts=3)
    with serving(fake_fit.quick) as service:
        assert ended(service, named("twice")).state == "done"
        fit = ended(service, named("thrice"))
        assert fit.reason == TOO_OFTEN.format(3)
        assert [event.kind for event in stored_events(service, named("thrice"))] == ["started", "iterated", "failed"]


def test_a_fit_does_not_go_on_with_another_model(serving, storage: Storage, scan_id: str) -> None:
    begun(storage, scan_id, named("interrupted"), 0)
    append(storage, named("interrupted"), {"kind": "started", "stance": "standing", "model_sha256": "1" * 64})
    with serving(fake_fit.quick) as service:
        assert ended(service, named("interrupted")).reason == OTHER_MODEL


def test_a_fit_that_is_started_again_has_the_stance_that_was_asked_for(serving, storage: Storage, scan_id: str) -> None:
    begun(storage, scan_id, named("interrupted"), 0)
    append(storage, named("interrupted"), {"kind": "started", "stance": "supine", "model_sha256": "0" * 64})
    fit = get_fit(storage, named("interrupted"))
    assert (fit.stance, fit.asked_stance) == ("supine", "auto")
    case, scan = storage.case_of_fit(fit.id)
    assert job_of(case, scan, find_fit(case, fit.id).document, Path(), None).stance == "auto"


def test_a_worker_that_does_not_see_the_data_says_so_and_makes_none_up(
    serving, scan_id: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with serving(fake_fit.quick) as service:
        monkeypatch.setattr(service._queue, "_root", tmp_path / "elsewhere")
        fit = ended(service, ask_for_fit(service, scan_id))
        assert (fit.state, fit.reason) == ("failed", UNSEEN)
    assert not (tmp_path / "elsewhere").exists()


def test_stopping_the_server_keeps_what_runs_and_what_waits_for_the_next(
    serving, storage: Storage, scan_id: str
) -> None:
    with serving(fake_fit.patient, workers=1) as service:
        running, waiting = ask_for_fit(service, scan_id), ask_for_fit(service, scan_id)
        until(lambda: get_fit(service.storage, running).iterations > 0, "the first iteration")
    assert [get_fit(storage, fit).state for fit in (running, waiting)] == ["running", "queued"]
    last = get_fit(storage, running).last_event
    with serving(fake_fit.quick, workers=1) as service:
        for fit in (running, waiting):
            assert ended(service, fit).state == "done"
        assert get_fit(storage, running).last_event == max(last, 5) + 1


def test_a_stopping_server_lets_a_fit_finish_that_is_nearly_done(serving, storage: Storage, scan_id: str) -> None:
    with serving(fake_fit.quick, grace_s=10.0) as service:
        fit_id = ask_for_fit(service, scan_id)
        until(lambda: get_fit(service.storage, fit_id).state != "queued", "the start")
    assert get_fit(storage, fit_id).state == "done"


def test_deleting_a_scan_stops_its_fits_and_leaves_nothing(serving, storage: Storage, scan_id: str) -> None:
    with serving(fake_fit.patient) as service:
        fit_ids = [ask_for_fit(service, scan_id) for _ in range(3)]
        until(lambda: get_fit(service.storage, fit_ids[0]).iterations > 1, "some iterations")
        service.delete_scan(scan_id)
        service.delete_scan(scan_id)
        with pytest.raises(NotFound):
            get_scan(service.storage, scan_id)
        left = _files(storage.root)
        ours = ("models/", "index", "audit/")
        assert {name for name in left if not name.startswith(ours)} == {"lock", "installation"}
        left = bytes_below(storage.root, "index-*")
        assert not any(one.encode() in left for one in (scan_id, *fit_ids))


def test_a_killed_idle_process_does_not_break_the_queue(serving, scan_id: str) -> None:
    with serving(fake_fit.quick) as service:
        os.kill(service.pool.queue(1, 2**32).result(os.getpid, (), 30.0, scan_id), 9)
        assert ended(service, ask_for_fit(service, scan_id)).state == "done"


def _files(root: Path) -> set[str]:
    return {path.relative_to(root).as_posix() for path in root.rglob("*") if path.is_file()}


def test_an_end_that_cannot_be_stored_at_once_is_stored_later(serving, scan_id: str, monkeypatch) -> None:
    real, refusals = queue.end_abandoned, [1, 2, 3]

    def full_at_first(*args):
        if refusals:
            refusals.pop()
            raise OSError(28, "No space left on device")
        return real(*args)

    monkeypatch.setattr(queue, "SETTLE_AGAIN_S", 0.02)
    monkeypatch.setattr(queue, "end_abandoned", full_at_first)
    with serving(fake_fit.dying) as service:
        fit = ended(service, ask_for_fit(service, scan_id))
        assert (fit.state, refusals) == ("failed", [])
