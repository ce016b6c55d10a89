import os
from contextlib import suppress
from pathlib import Path

import pytest
from helpers import fake_fit
from helpers.on_disk import bytes_below
from helpers.rows import add_waiting_fit
from helpers.waiting import ask_for_fit, ended, story, until
from sqlalchemy.exc import OperationalError

from breastrig.core.errors import Conflict, NotFound
from breastrig.jobs import queue
from breastrig.jobs.queue import STOPPED
from breastrig.storage.events import append, events_after
from breastrig.storage.fits import claim_fit, get_fit
from breastrig.storage.scans import get_scan
from breastrig.storage.storage import Storage


def test_a_fit_tells_its_story_in_order_and_leaves_its_files(serving, scan_id: str) -> None:
    with serving(fake_fit.quick) as service:
        fit_id = ask_for_fit(service, scan_id)
        events = story(service, fit_id)
        assert [event.kind for event in events] == ["started", *["iterated"] * 4, "done"]
        assert [event.number for event in events] == [1, 2, 3, 4, 5, 6]
        assert get_fit(service.storage, fit_id).state == "done"
        assert (service.storage.folders.fit(fit_id) / "result.json").is_file()
        assert story(service, fit_id) == events
        assert story(service, fit_id, after=4) == events[4:]


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
        for _ in range(3):  # more than there are workers
            fit = ended(service, ask_for_fit(service, scan_id))
            assert fit.state == "failed"
            assert fit.reason is not None
            assert fit.reason.startswith(sentence)


def test_a_fit_that_takes_too_long_is_stopped(serving, scan_id: str) -> None:
    with serving(fake_fit.hanging, wall_s=0.3) as service:
        fit = ended(service, ask_for_fit(service, scan_id))
        assert (fit.state, fit.reason) == ("failed", "The fit took longer than 0.3 s and was stopped.")


def test_cancelling_a_running_fit_kills_its_process(serving, scan_id: str) -> None:
    with serving(fake_fit.patient) as service:
        fit_id = ask_for_fit(service, scan_id)
        until(lambda: get_fit(service.storage, fit_id).iterations > 1, "some iterations")
        assert service.cancel_fit(fit_id).state == "cancelled"
        assert service.storage.folders.wait_until_free(service.storage.folders.fit(fit_id), 5.0)
        events = events_after(service.storage, fit_id, 0)
        assert events[-1].kind == "cancelled"
        assert service.cancel_fit(fit_id).state == "cancelled"


def test_cancelling_a_waiting_fit_means_that_it_never_runs(serving, scan_id: str) -> None:
    with serving(fake_fit.mostly_patient, workers=1) as service:
        running = ask_for_fit(service, scan_id, "paper")
        waiting = ask_for_fit(service, scan_id)
        last = ask_for_fit(service, scan_id)
        service.cancel_fit(waiting)
        service.cancel_fit(running)
        assert ended(service, last).state == "done"
        assert [event.kind for event in events_after(service.storage, waiting, 0)] == ["cancelled"]


def test_a_fit_that_is_done_cannot_be_cancelled(serving, scan_id: str) -> None:
    with serving(fake_fit.quick) as service:
        fit_id = ask_for_fit(service, scan_id)
        ended(service, fit_id)
        with pytest.raises(Conflict, match="it is done"):
            service.cancel_fit(fit_id)
        with pytest.raises(NotFound):
            service.cancel_fit("nobody")


def test_more_fits_than_workers_all_run(serving, scan_id: str) -> None:
    with serving(fake_fit.quick) as service:
        fit_ids = [ask_for_fit(service, scan_id) for _ in range(7)]
        assert {ended(service, fit_id).state for fit_id in fit_ids} == {"done"}


def test_after_a_restart_waiting_fits_run_and_running_ones_are_failed(serving, storage: Storage, scan_id: str) -> None:
    interrupted, waiting = "interrupted", "waiting"
    for fit_id in (interrupted, waiting):
        storage.folders.make(storage.folders.fit(fit_id))
        add_waiting_fit(storage, scan_id, fit_id)
    claim_fit(storage, interrupted)
    append(storage, interrupted, {"kind": "started", "stance": "standing"})
    with serving(fake_fit.quick) as service:
        assert ended(service, waiting).state == "done"
        fit = get_fit(service.storage, interrupted)
        assert (fit.state, fit.reason) == ("failed", STOPPED)
        assert [event.kind for event in story(service, interrupted)] == ["started", "failed"]


def test_stopping_the_server_fails_what_runs_and_keeps_what_waits(serving, storage: Storage, scan_id: str) -> None:
    with serving(fake_fit.patient, workers=1) as service:
        running, waiting = ask_for_fit(service, scan_id), ask_for_fit(service, scan_id)
        until(lambda: get_fit(service.storage, running).iterations > 0, "the first iteration")
    assert (get_fit(storage, running).state, get_fit(storage, running).reason) == ("failed", STOPPED)
    assert get_fit(storage, waiting).state == "queued"


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
        assert _files(storage.root) == {"lock", "breastrig.sqlite3", "breastrig.sqlite3-wal", "breastrig.sqlite3-shm"}
        left = bytes_below(storage.root, "breastrig.sqlite3*")
        assert not any(one.encode() in left for one in (scan_id, *fit_ids))


def test_a_killed_idle_process_does_not_break_the_queue(serving, scan_id: str) -> None:
    with serving(fake_fit.quick) as service:
        until(lambda: _alive(service), "all processes")
        for pid in list(service._workers._pool._pool_manager.worker_manager.workers):
            with suppress(ProcessLookupError):  # the pool ends the other one itself when it notices the first
                os.kill(pid, 9)
        until(lambda: not service._workers._pool.active, "the pool to notice")
        assert ended(service, ask_for_fit(service, scan_id)).state == "done"


def _alive(service) -> bool:
    workers = service._workers._pool._pool_manager.worker_manager.workers
    return len(workers) == 2 and all(worker.is_alive() for worker in list(workers.values()))


def _files(root: Path) -> set[str]:
    return {path.relative_to(root).as_posix() for path in root.rglob("*") if path.is_file()}


def test_an_end_that_cannot_be_stored_at_once_is_stored_later(serving, scan_id: str, monkeypatch) -> None:
    real, refusals = queue.append, [1, 2, 3]

    def full_at_first(*args):
        if refusals:
            refusals.pop()
            raise OperationalError("INSERT", {}, Exception("database or disk is full"))
        return real(*args)

    monkeypatch.setattr(queue, "SETTLE_AGAIN_S", 0.02)
    monkeypatch.setattr(queue, "append", full_at_first)
    with serving(fake_fit.dying) as service:
        fit = ended(service, ask_for_fit(service, scan_id))
        assert (fit.state, refusals) == ("failed", [])
