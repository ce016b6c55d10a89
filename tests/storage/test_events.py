import threading

import pytest
from helpers.rows import add_waiting_fit

from breastrig.core.errors import Conflict, NotFound
from breastrig.storage.rows.events import append, event_of_kind, events_after, news_after
from breastrig.storage.rows.fits import claim_fit, fits_in_state, get_fit, next_queued, put_back
from breastrig.storage.storage import Storage


def iterated(iteration: int) -> dict[str, object]:
    return {"kind": "iterated", "iteration": iteration, "energy": 1.5, "nodes": [{"name": "pelvis"}]}


def test_events_are_numbered_from_one_and_replayed_from_any_number(storage: Storage, fit_id: str) -> None:
    assert [append(storage, fit_id, iterated(k)) for k in range(3)] == [1, 2, 3]
    assert [event.number for event in events_after(storage, fit_id, 0)] == [1, 2, 3]
    assert [event.number for event in events_after(storage, fit_id, 2)] == [3]
    assert events_after(storage, fit_id, 9) == []
    assert '"iteration":1' in event_of_kind(storage, fit_id, "iterated", offset=1).json


def test_the_fit_follows_its_events(storage: Storage, fit_id: str) -> None:
    append(storage, fit_id, {"kind": "started", "stance": "supine"})
    append(storage, fit_id, iterated(0))
    append(storage, fit_id, iterated(1))
    fit = get_fit(storage, fit_id)
    assert (fit.stance, fit.iterations, fit.last_event) == ("supine", 2, 3)
    assert fit.numbers == {"iteration": 1, "energy": 1.5}
    append(storage, fit_id, {"kind": "done", "result": {"verdict": {"level": "check", "reasons": []}}})
    assert (get_fit(storage, fit_id).state, get_fit(storage, fit_id).verdict) == ("done", "check")


def test_nothing_comes_after_the_last_event(storage: Storage, fit_id: str) -> None:
    append(storage, fit_id, {"kind": "cancelled", "reason": "enough"})
    with pytest.raises(Conflict, match="already ended: it is cancelled"):
        append(storage, fit_id, {"kind": "done", "result": {}})
    assert (get_fit(storage, fit_id).state, get_fit(storage, fit_id).reason) == ("cancelled", "enough")
    assert len(events_after(storage, fit_id, 0)) == 1


def test_a_fit_ends_once_however_many_end_it(storage: Storage, fit_id: str) -> None:
    outcomes: list[str] = []

    def end(kind: str) -> None:
        try:
            append(storage, fit_id, {"kind": kind, "reason": kind})
            outcomes.append(kind)
        except Conflict:
            outcomes.append("refused")

    threads = [threading.Thread(target=end, args=(kind,)) for kind in ("failed", "cancelled") * 4]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert outcomes.count("refused") == 7
    assert get_fit(storage, fit_id).state in outcomes


def test_numbers_that_are_not_finite_are_never_stored(storage: Storage, fit_id: str) -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        append(storage, fit_id, {"kind": "iterated", "energy": float("nan")})
    assert events_after(storage, fit_id, 0) == []


def test_an_event_of_nobody_is_refused(storage: Storage) -> None:
    with pytest.raises(NotFound):
        append(storage, "nobody", iterated(0))


def test_news_name_each_fit_once_and_say_what_moves_the_queue(storage: Storage, scan_id: str) -> None:
    assert news_after(storage, 0) == []
    for fit_id in ("fit-a", "fit-b"):
        add_waiting_fit(storage, scan_id, fit_id)
        append(storage, fit_id, iterated(0))
        append(storage, fit_id, iterated(1))
    first, second = sorted(news_after(storage, 0), key=lambda one: one.fit)
    assert (first.fit, first.moves_queue, second.fit, second.moves_queue) == ("fit-a", False, "fit-b", False)
    assert first.position < second.position
    assert news_after(storage, first.position) == [second]
    assert news_after(storage, second.position) == []
    append(storage, "fit-a", {"kind": "cancelled", "reason": "so it is"})
    append(storage, "fit-b", iterated(2))
    last = {one.fit: one.moves_queue for one in news_after(storage, second.position)}
    assert last == {"fit-a": True, "fit-b": False}


def test_the_oldest_waiting_fit_is_next(storage: Storage, scan_id: str) -> None:
    for fit_id in ("fit-z", "fit-a"):
        add_waiting_fit(storage, scan_id, fit_id)
    assert next_queued(storage, set()) == "fit-z"
    assert next_queued(storage, {"fit-z"}) == "fit-a"
    claimed = claim_fit(storage, "fit-z")
    assert claimed is not None
    assert claimed.landmarks_mm == {"nipple_L": [1.0, 2.0, 3.0]}
    assert next_queued(storage, set()) == "fit-a"
    assert fits_in_state(storage, "running") == ["fit-z"]


def test_a_claim_takes_the_fit_from_whoever_was_at_it(storage: Storage, fit_id: str) -> None:
    claims = [claim_fit(storage, fit_id) for _ in range(2)]
    assert [claim and claim.attempt for claim in claims] == [1, 2]
    with pytest.raises(Conflict, match="Another worker has taken this fit over"):
        append(storage, fit_id, iterated(0), attempt=1)
    assert append(storage, fit_id, iterated(0), attempt=2) == 1


def test_a_fit_that_was_put_back_takes_no_event_of_its_old_worker(storage: Storage, fit_id: str) -> None:
    claim_fit(storage, fit_id)
    append(storage, fit_id, iterated(0), attempt=1)
    assert put_back(storage) == 1
    assert (get_fit(storage, fit_id).state, next_queued(storage, set())) == ("queued", fit_id)
    with pytest.raises(Conflict, match="Another worker has taken this fit over"):
        append(storage, fit_id, iterated(1), attempt=1)
    assert put_back(storage) == 0
    assert [event.number for event in events_after(storage, fit_id, 0)] == [1]


def test_a_cancelled_fit_is_never_claimed(storage: Storage, fit_id: str) -> None:
    append(storage, fit_id, {"kind": "cancelled", "reason": "enough"})
    assert claim_fit(storage, fit_id) is None
    assert next_queued(storage, set()) is None
