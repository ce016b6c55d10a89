import sqlite3
import threading
from itertools import chain

import pytest
from helpers import fake_fit
from helpers.stored_fits import add_waiting_fit, append, named
from helpers.waiting import PATIENCE_S, ask_for_fit, stored_events, until

from breastrig.index.questions import note_state
from breastrig.service.events import feeds
from breastrig.service.events.feeds import LOOK_EVERY_S, Heartbeat, Listener, Notifier, Queued, follow
from breastrig.storage.deletion import delete_scan
from breastrig.storage.documents.events import StoredEvent, events_after
from breastrig.storage.storage import Storage


def test_everyone_who_listens_hears_the_same(serving, scan_id: str) -> None:
    with serving(fake_fit.quick) as service:
        fit_id = ask_for_fit(service, scan_id)
        heard: dict[int, list[int]] = {}

        def listen(number: int) -> None:
            heard[number] = [event.number for event in stored_events(service, fit_id)]

        threads = [threading.Thread(target=listen, args=(number,)) for number in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert heard == {number: [1, 2, 3, 4, 5, 6] for number in range(8)}


def test_a_stored_event_is_heard_without_waiting_for_a_heartbeat(storage: Storage, scan_id: str) -> None:
    add_waiting_fit(storage, scan_id, named("fit"))
    notifier = Notifier(storage)
    notifier.start()
    try:
        heard: list[StoredEvent] = []

        def listen() -> None:
            news = chain.from_iterable(follow(notifier, named("fit"), 0, 3600.0))
            heard.extend(event for event in news if isinstance(event, StoredEvent))

        thread = threading.Thread(target=listen)
        thread.start()
        until(lambda: notifier.listening == 1, "the listener")
        append(storage, named("fit"), {"kind": "failed", "reason": "so it is"})
        until(lambda: not thread.is_alive(), "the end of the stream")
        assert [event.kind for event in heard] == ["failed"]
        assert LOOK_EVERY_S < 0.1
    finally:
        notifier.stop()


def test_news_of_one_fit_wake_only_those_whom_they_concern(
    storage: Storage, scan_id: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The fit's own viewers; those whose fit waits, only where it moves up."""
    notified: list[str] = []
    monkeypatch.setattr(Listener, "set", lambda listener: notified.append(names[listener]))
    for fit_id in ("mine", "other", "waiting"):
        add_waiting_fit(storage, scan_id, named(fit_id))
    for fit_id in ("other", "mine"):
        with storage.index.writing() as rows:
            note_state(rows, named(fit_id), "running")
    notifier = Notifier(storage)
    with (
        notifier.listen(named("mine")) as mine,
        notifier.listen(named("other")) as other,
        notifier.listen(named("waiting")) as waiting,
    ):
        names = {mine: "mine", other: "other", waiting: "waiting"}
        notifier.start()
        try:
            append(storage, named("mine"), {"kind": "iterated", "nodes": []})
            until(lambda: notified == ["mine"], "the ring for an iteration")
            append(storage, named("mine"), {"kind": "failed", "reason": "so it is"})
            until(lambda: len(notified) == 2, "the ring for an end")
            with storage.index.writing() as rows:
                note_state(rows, named("waiting"), "running")
            until(lambda: len(notified) == 3, "the ring for the one that waits no more")
            assert notified == ["mine", "mine", "waiting"]
        finally:
            notifier.stop()
    assert notifier.listening == 0


def test_a_waiting_fit_hears_that_it_moves_up(storage: Storage, scan_id: str) -> None:
    for fit_id in ("first", "second"):
        add_waiting_fit(storage, scan_id, named(fit_id))
    notifier = Notifier(storage)
    notifier.start()
    try:
        stream = follow(notifier, named("second"), 0, 60.0)
        assert next(stream) == [Queued(2)]
        timer = threading.Timer(0.05, append, (storage, named("first"), {"kind": "cancelled", "reason": "so it is"}))
        timer.start()
        assert next(stream) == [Queued(1)]
        timer.join()
        stream.close()
    finally:
        notifier.stop()


def test_many_who_follow_one_fit_ask_the_database_no_more_than_one(storage: Storage, scan_id: str) -> None:
    """What the notifier has read once is the same list for all."""
    add_waiting_fit(storage, scan_id, named("fit"))
    asked: list[object] = []
    real = storage.index.asked
    storage.index.asked = lambda question, *given: (asked.append(question), real(question, *given))[1]
    notifier = Notifier(storage)
    streams = [follow(notifier, named("fit"), 0, 3600.0) for _ in range(20)]
    assert {next(stream)[0] for stream in streams} == {Queued(1)}
    assert len(asked) <= 6
    notifier.start()
    try:
        append(storage, named("fit"), {"kind": "failed", "reason": "so it is"})
        heard = [next(streams[0])]
        asked.clear()
        heard += [next(stream) for stream in streams[1:]]
        assert asked == []
        assert [[one.kind for one in together] for together in heard] == [["failed"]] * 20
        assert len({id(together[0]) for together in heard}) == 1
        assert [list(stream) for stream in streams] == [[]] * 20
    finally:
        notifier.stop()
    assert notifier.listening == 0


def test_a_feed_that_could_not_be_read_is_read_again(
    storage: Storage, scan_id: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    add_waiting_fit(storage, scan_id, named("fit"))
    notifier = Notifier(storage)
    fails = [True]

    def read(*args: object) -> list[StoredEvent]:
        if fails and args[2] == 0 and notifier.listening and notifier._thread is threading.current_thread():
            fails.clear()
            raise sqlite3.OperationalError("database is locked")
        return events_after(*args)

    stream = follow(notifier, named("fit"), 0, 3600.0)
    assert next(stream) == [Queued(1)]
    monkeypatch.setattr(feeds, "events_after", read)
    append(storage, named("fit"), {"kind": "failed", "reason": "so it is"})
    notifier.start()
    try:
        assert [one.kind for one in next(stream)] == ["failed"]
        assert not fails
    finally:
        notifier.stop()


def test_a_silent_stream_beats(storage: Storage, scan_id: str) -> None:
    add_waiting_fit(storage, scan_id, named("fit"))
    notifier = Notifier(storage)
    notifier.start()
    try:
        stream = follow(notifier, named("fit"), 0, 0.01)
        assert next(stream) == [Queued(1)]
        assert next(stream) == [Heartbeat()]
        assert next(stream) == [Heartbeat()]
        stream.close()
    finally:
        notifier.stop()


def test_who_comes_late_hears_all_that_is_stored_together(storage: Storage, scan_id: str) -> None:
    add_waiting_fit(storage, scan_id, named("fit"))
    notifier = Notifier(storage)
    append(storage, named("fit"), {"kind": "iterated", "nodes": []})
    append(storage, named("fit"), {"kind": "iterated", "nodes": []})
    append(storage, named("fit"), {"kind": "failed", "reason": "so it is"})
    assert [[event.number for event in together] for together in follow(notifier, named("fit"), 0, 60.0)] == [[1, 2, 3]]
    assert [[event.number for event in together] for together in follow(notifier, named("fit"), 2, 60.0)] == [[3]]


def test_a_stream_ends_when_the_fit_is_deleted(storage: Storage, scan_id: str) -> None:
    add_waiting_fit(storage, scan_id, named("fit"))
    notifier = Notifier(storage)
    notifier.start()
    try:
        thread = threading.Thread(target=lambda: list(follow(notifier, named("fit"), 0, 60.0)))
        thread.start()
        until(lambda: notifier.listening == 1, "the listener")
        delete_scan(storage, scan_id)
        notifier.look_again()
        thread.join(timeout=PATIENCE_S)
        assert not thread.is_alive()
    finally:
        notifier.stop()


def test_a_stream_ends_when_the_notifier_stops_or_the_viewer_leaves(storage: Storage, scan_id: str) -> None:
    add_waiting_fit(storage, scan_id, named("fit"))
    notifier = Notifier(storage)
    notifier.start()
    assert list(follow(notifier, named("fit"), 0, 60.0, gone=lambda: True)) == [[Queued(1)]]
    notifier.stop()
    assert list(follow(notifier, named("fit"), 0, 60.0)) == []
