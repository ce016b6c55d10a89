"""Tasks of a key in the process that is kept for it, and everywhere else when that is not to be had."""

import os
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from typing import Any

import pytest
from helpers import in_worker
from helpers.waiting import until

from breastrig.core.errors import BadScan
from breastrig.execution.kept_processes import KeptProcesses
from breastrig.execution.processes import Processes
from breastrig.execution.warm_first import ForKey, WarmFirst

GIB = 2**30


@pytest.fixture
def kept() -> Iterator[KeptProcesses]:
    processes = KeptProcesses(4 * GIB, kept=2)
    yield processes
    processes.stop()


@pytest.fixture
def warm(kept: KeptProcesses) -> Iterator[WarmFirst]:
    executor = WarmFirst(
        Processes(2, memory_bytes=4 * GIB), kept, in_worker.call_as_kept, memory_bytes=3 * GIB, cpu_s=60
    )
    yield executor
    executor.stop()


def begun(warm: WarmFirst, key: str, function: Callable[..., Any], *given: Any) -> "Future[Any]":
    return warm.schedule(ForKey(key, function, begins=True), given, 30.0)


def later(warm: WarmFirst, key: str, function: Callable[..., Any], *given: Any) -> "Future[Any]":
    return warm.schedule(ForKey(key, function), given, 30.0)


def seen(future: "Future[Any]") -> list[str]:
    _, words = future.result(30.0)
    return list(words)


def is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def rests(kept: KeptProcesses, key: str) -> None:
    until(lambda: kept.asked(key) == 0, "the end of a task")


def test_later_tasks_of_a_key_find_what_the_first_has_left_and_nobody_else_does(
    warm: WarmFirst, kept: KeptProcesses
) -> None:
    assert seen(begun(warm, "a", in_worker.remember, "one")) == ["one"]
    rests(kept, "a")
    assert seen(later(warm, "a", in_worker.remember, "two")) == ["one", "two"]
    assert seen(later(warm, "b", in_worker.remember, "three")) == ["three"]
    assert seen(begun(warm, "b", in_worker.remember, "four")) == ["four"]
    assert seen(warm.schedule(in_worker.remember, ("five",), 30.0)) == ["five"]
    rests(kept, "a")
    assert seen(later(warm, "a", in_worker.remember, "six")) == ["one", "two", "six"]


def test_a_task_does_not_wait_for_the_process_of_its_key(warm: WarmFirst, kept: KeptProcesses) -> None:
    resting = begun(warm, "a", in_worker.rest, 30.0)
    assert seen(later(warm, "a", in_worker.remember, "one")) == ["one"]
    assert not resting.done()
    kept.drop("a")


def test_keys_at_work_keep_their_places(warm: WarmFirst, kept: KeptProcesses) -> None:
    for key in ("a", "b"):
        begun(warm, key, in_worker.rest, 30.0)
    assert seen(begun(warm, "c", in_worker.remember, "one")) == ["one"]
    assert (kept.asked("a"), kept.asked("b"), len(kept)) == (1, 1, 2)
    for key in ("a", "b"):
        kept.drop(key)


def test_each_task_has_the_limits_of_its_pool_whatever_was_used_before(warm: WarmFirst, kept: KeptProcesses) -> None:
    first = begun(warm, "a", in_worker.burn_for, 1.2).result(30.0)
    rests(kept, "a")
    found = later(warm, "a", in_worker.describe).result(30.0)
    assert found["pid"] == first
    assert found["memory"][0] == 3 * GIB
    assert 61 <= found["cpu"][0] <= 65
    assert found["core"] == (0, 0)


@pytest.mark.parametrize("by", ["time", "cancel", "death"])
def test_what_ends_a_task_by_force_ends_its_process_and_the_next_starts_elsewhere(
    warm: WarmFirst, kept: KeptProcesses, by: str
) -> None:
    first, _ = begun(warm, "a", in_worker.remember, "one").result(30.0)
    rests(kept, "a")
    function, wall_s = (in_worker.lose, 30.0) if by == "death" else (in_worker.burn, 0.5 if by == "time" else 30.0)
    lost = warm.schedule(ForKey("a", function), (), wall_s)
    if by == "cancel":
        until(lost.running, "the start of a task")
        lost.cancel()
        assert lost.cancelled()
    else:
        with pytest.raises((OSError, RuntimeError, TimeoutError)):
            lost.result(30.0)
    until(lambda: not is_alive(first), "the end of a process")
    assert len(kept) == 0
    assert seen(later(warm, "a", in_worker.remember, "two")) == ["two"]


def test_a_refusal_is_handed_on_and_the_process_stays(warm: WarmFirst, kept: KeptProcesses) -> None:
    begun(warm, "a", in_worker.remember, "one").result(30.0)
    rests(kept, "a")
    with pytest.raises(BadScan, match="too small"):
        later(warm, "a", in_worker.refuse, "too small").result(30.0)
    rests(kept, "a")
    assert seen(later(warm, "a", in_worker.remember, "two")) == ["one", "two"]


def test_a_process_that_has_grown_large_is_ended() -> None:
    kept = KeptProcesses(4 * GIB, large_bytes=1)
    try:
        future = kept.begin("a", in_worker.remember, ("one",), 30.0, new=True)
        assert future is not None
        pid, _ = future.result(30.0)
        until(lambda: not is_alive(pid), "the end of a process")
        assert len(kept) == 0
    finally:
        kept.stop()


def test_what_stands_ready_has_served_nobody_and_serves_one_key() -> None:
    kept = KeptProcesses(4 * GIB, ready=True)
    try:
        kept.stand_ready()
        for key in ("a", "b"):
            future = kept.begin(key, in_worker.remember, (key,), 30.0, new=True)
            assert future is not None
            assert seen(future) == [key]
    finally:
        kept.stop()


def test_dropping_a_key_waits_for_the_end_of_a_process_that_was_let_go(warm: WarmFirst, kept: KeptProcesses) -> None:
    pid, _ = begun(warm, "a", in_worker.remember, "one").result(30.0)
    rests(kept, "a")
    for key in ("b", "c"):  # takes the place of a
        begun(warm, key, in_worker.remember, key).result(30.0)
        rests(kept, key)
        time.sleep(0.01)  # so that one was asked for before the other
    kept.drop("a")
    assert not is_alive(pid)


def test_a_stopped_executor_has_no_process_left(warm: WarmFirst, kept: KeptProcesses) -> None:
    pid, _ = begun(warm, "a", in_worker.remember, "one").result(30.0)
    warm.stop()
    assert not is_alive(pid)
    with pytest.raises(RuntimeError, match="stopped"):
        later(warm, "a", in_worker.remember, "two")
