"""Processes that keep what they have read: one for each key, and nothing left of it when the key is dropped."""

import os
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest
from helpers import in_worker
from helpers.waiting import until

from breastrig.core.errors import BadScan, TooMany
from breastrig.execution.kept_processes import WAITING, KeptProcesses

GIB = 2**30


@pytest.fixture
def kept() -> Iterator[KeptProcesses]:
    processes = KeptProcesses(4 * GIB, kept=2)
    yield processes
    processes.stop()


def ask(kept: KeptProcesses, key: str, word: str) -> tuple[int, list[str]]:
    pid, seen = kept.result(key, in_worker.remember, (word,), 30.0)
    return int(pid), list(seen)


def is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def test_a_key_keeps_its_process_and_shares_it_with_no_other(kept: KeptProcesses) -> None:
    first, _ = ask(kept, "a", "one")
    other, of_other = ask(kept, "b", "two")
    again, seen = ask(kept, "a", "three")
    assert (first, seen) == (again, ["one", "three"])
    assert other != first
    assert of_other == ["two"]


def test_a_dropped_key_has_no_process_any_more_and_begins_anew(kept: KeptProcesses) -> None:
    first, _ = ask(kept, "a", "one")
    kept.drop("a")
    until(lambda: not is_alive(first), "the end of a process")
    second, seen = ask(kept, "a", "two")
    assert (second != first, seen) == (True, ["two"])


def test_the_one_that_was_not_asked_for_longest_makes_room(kept: KeptProcesses) -> None:
    first, _ = ask(kept, "a", "one")
    second, _ = ask(kept, "b", "one")
    ask(kept, "a", "two")
    ask(kept, "c", "one")
    assert len(kept) == 2
    until(lambda: not is_alive(second), "the end of a process")
    assert ask(kept, "a", "three")[0] == first


def test_a_process_that_was_not_asked_for_a_while_is_ended() -> None:
    kept = KeptProcesses(4 * GIB, idle_s=0.2)
    try:
        pid, _ = ask(kept, "a", "one")
        until(lambda: not is_alive(pid), "the end of a process")
        assert len(kept) == 0
    finally:
        kept.stop()


def test_an_error_of_a_question_is_handed_on_and_the_process_stays(kept: KeptProcesses) -> None:
    first, _ = ask(kept, "a", "one")
    with pytest.raises(BadScan, match="too small"):
        kept.result("a", in_worker.refuse, ("too small",), 30.0)
    assert ask(kept, "a", "two") == (first, ["one", "two"])


def test_a_lost_process_ends_one_question_and_the_next_has_another(kept: KeptProcesses) -> None:
    first, _ = ask(kept, "a", "one")
    with pytest.raises((OSError, RuntimeError)):
        kept.result("a", in_worker.lose, (), 30.0)
    second, seen = ask(kept, "a", "two")
    assert (second != first, seen) == (True, ["two"])


def test_a_question_that_takes_too_long_is_ended_with_its_process(kept: KeptProcesses) -> None:
    first, _ = ask(kept, "a", "one")
    with pytest.raises(TimeoutError):
        kept.result("a", in_worker.burn, (), 0.5)
    until(lambda: not is_alive(first), "the end of a process")
    assert ask(kept, "a", "two")[1] == ["two"]


def test_more_questions_to_one_process_than_may_wait_are_refused_for_now(kept: KeptProcesses) -> None:
    ask(kept, "a", "one")
    with ThreadPoolExecutor(WAITING) as threads:
        resting = [threads.submit(kept.result, "a", in_worker.rest, (30.0,), 60.0) for _ in range(WAITING)]
        until(lambda: kept.asked("a") == WAITING, "questions under way")
        with pytest.raises(TooMany, match="ask again in 1 s"):
            ask(kept, "a", "two")
        kept.drop("a")
        for each in resting:
            with pytest.raises((OSError, RuntimeError)):
                each.result(30.0)


def test_as_many_as_may_be_at_work_refuse_another_key_for_now(kept: KeptProcesses) -> None:
    with ThreadPoolExecutor(2) as threads:
        resting = [threads.submit(kept.result, key, in_worker.rest, (30.0,), 60.0) for key in ("a", "b")]
        until(lambda: kept.asked("a") == kept.asked("b") == 1, "questions under way")
        with pytest.raises(TooMany, match="2 scans"):
            ask(kept, "c", "one")
        for key in ("a", "b"):
            kept.drop(key)
        for each in resting:
            with pytest.raises((OSError, RuntimeError)):
                each.result(30.0)


def test_stopped_processes_leave_no_thread_and_take_no_questions() -> None:
    others = set(threading.enumerate())  # a service that other tests share may keep processes too
    kept = KeptProcesses(4 * GIB)
    pid, _ = ask(kept, "a", "one")
    assert "breastrig-kept" in {thread.name for thread in set(threading.enumerate()) - others}
    kept.stop()
    assert not is_alive(pid)
    assert "breastrig-kept" not in {thread.name for thread in set(threading.enumerate()) - others}
    with pytest.raises(RuntimeError, match="stopped"):
        ask(kept, "a", "two")
