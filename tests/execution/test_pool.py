"""The pool of processes: what a task is given, what ends it, whose turn it is, and what is kept for a key."""

import json
import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future, wait
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from helpers import in_worker
from helpers.waiting import until

from breastrig.core.errors import BadScan, TooMany
from breastrig.execution import worker as execution
from breastrig.execution.pool import Pool, TaskQueue, client_key

pytestmark = pytest.mark.long

GIB = 2**30


@pytest.fixture
def pool() -> Iterator[Pool]:
    pool = Pool(most_idle=2)
    yield pool
    pool.stop()


@pytest.fixture
def queue(pool: Pool) -> TaskQueue:
    """One place, and three tasks a client."""
    return pool.queue(1, 4 * GIB, 3)


@contextmanager
def asking(client: str | None) -> Iterator[None]:
    before = client_key.set(client)
    try:
        yield
    finally:
        client_key.reset(before)


def is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def ask(queue: TaskQueue, key: str | None, word: str) -> tuple[int, list[str]]:
    """The process, and all words that it was asked to remember."""
    pid, words = queue.result(in_worker.remember, (word,), 30.0, key)
    return int(pid), list(words)


def at_rest(queue: TaskQueue, file: Path, key: str | None = None) -> "tuple[Future[Any], int]":
    """A task that runs for ever, and its process."""
    task = queue.schedule(in_worker.sign_in_and_rest, (str(file), 600.0, 1), 900.0, key)
    until(lambda: file.exists() and file.read_text().endswith("\n"), "the task to run")
    return task, int(file.read_text())


# What a task is given


def test_a_task_runs_alone_within_its_limits_and_with_one_thread(queue: TaskQueue) -> None:
    first, second = (queue.result(in_worker.describe, (), 30.0) for _ in range(2))
    assert first["pid"] != second["pid"]
    assert (first["memory"][0], first["core"]) == (4 * GIB, (0, 0))
    assert first["threads"] == [1]
    assert first["garbage"] == (True, True)  # looked for, but not among the modules


def answer_of_a_program(name: str, *words: str) -> Any:
    program = Path(in_worker.__file__).with_name(name)
    answer = subprocess.run(
        [sys.executable, str(program), *words], capture_output=True, text=True, check=False, timeout=120
    )
    assert (answer.returncode, answer.stderr) == (0, "")
    return json.loads(answer.stdout)


def test_a_task_finds_imported_what_was_named_and_nothing_else_of_the_program() -> None:
    found = set(answer_of_a_program("preload.py", "colorsys", "breastrig.core.units", "no_such_module"))
    assert {"colorsys", "breastrig.core.units"} <= found
    assert "breastrig.core.documents" not in found  # which the program has imported


def test_stopping_while_processes_start_leaves_no_traceback_and_no_process() -> None:
    assert answer_of_a_program("stop_early.py") == []


# What ends it


def test_errors_come_to_whoever_asked(queue: TaskQueue) -> None:
    with pytest.raises(BadScan, match=r"^no scan$"):
        queue.result(in_worker.refuse, ("no scan",), 30.0)
    with pytest.raises(RuntimeError, match="Unpicklable: half and half"):
        queue.result(in_worker.raise_what_cannot_travel, (), 30.0)
    with pytest.raises((AttributeError, pickle.PicklingError), match="pickle"):
        queue.result(in_worker.give_what_cannot_travel, (), 30.0)
    with pytest.raises(MemoryError):
        queue.result(in_worker.fill, (8 * GIB,), 30.0)
    assert queue.answer(30.0)


def test_a_task_that_takes_too_long_is_stopped_and_the_next_one_runs(queue: TaskQueue) -> None:
    with pytest.raises(TimeoutError):
        queue.result(in_worker.burn, (), 0.2)
    assert ask(queue, None, "one")[1] == ["one"]


def test_a_process_that_dies_fails_its_own_task_only(pool: Pool) -> None:
    queue = pool.queue(2, 4 * GIB)
    dead = queue.schedule(in_worker.die, (signal.SIGKILL,), 30.0)
    fine = queue.schedule(in_worker.rest, (0.2,), 30.0)
    with pytest.raises(OSError, match="ended unexpectedly"):
        dead.result()
    assert fine.result() is None


def test_a_cancelled_task_ends_at_once_whether_it_runs_or_waits(queue: TaskQueue, tmp_path: Path) -> None:
    running, pid = at_rest(queue, tmp_path / "running")
    order = tmp_path / "order"
    waiting = queue.schedule(in_worker.note, (str(order), "never"), 30.0)
    last = queue.schedule(in_worker.note, (str(order), "last"), 30.0)
    assert waiting.cancel()
    assert running.cancel()
    assert running.cancel()  # again, to no effect
    assert wait([waiting, running], timeout=0).done == {waiting, running}
    with pytest.raises(CancelledError):
        running.result()
    assert last.result() is None
    assert order.read_text() == "last\n"
    until(lambda: not is_alive(pid), "the end of a process")


def test_a_stop_ends_what_runs_waits_and_rests_and_takes_nothing_more(
    pool: Pool, queue: TaskQueue, tmp_path: Path
) -> None:
    others = set(threading.enumerate())
    resting, _ = ask(queue, "a", "one")
    running, pid = at_rest(queue, tmp_path / "running")
    waiting = queue.schedule(in_worker.rest, (0.0,), 30.0)
    pool.stop()
    assert not is_alive(pid)
    assert not is_alive(resting)
    for task in (running, waiting):
        with pytest.raises(RuntimeError, match="stopped"):
            task.result(0)
    assert not {one for one in set(threading.enumerate()) - others if one.name == "breastrig-task"}
    assert not queue.answer(1.0)
    with pytest.raises(RuntimeError, match="stopped"):
        queue.schedule(in_worker.rest, (0.0,), 30.0)


def test_a_process_that_answers_nothing_is_no_pool(queue: TaskQueue, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(execution, "START_S", 0.0)
    with pytest.raises(RuntimeError, match="No process answers"):
        queue.warm_up()


# Whose turn it is


def test_a_client_with_one_task_does_not_wait_for_all_of_anothers(queue: TaskQueue, tmp_path: Path) -> None:
    order, end = tmp_path / "order", tmp_path / "end"

    def noted(text: str) -> "Future[Any]":
        return queue.schedule(in_worker.note_and_wait_for, (str(order), text, str(end)), 30.0)

    with asking("busy"):
        running, _ = at_rest(queue, tmp_path / "running")
        tasks = [noted(f"busy{number}") for number in range(2)]
    with asking("other"):
        beside, _ = at_rest(queue, tmp_path / "beside")  # the place that is left for others
        tasks.append(noted("other"))
    assert not any(task.done() for task in tasks)
    for task in (beside, running):
        task.cancel()
    until(lambda: order.exists() and len(order.read_text().splitlines()) == 2, "one of each to run")
    assert set(order.read_text().split()) == {"busy0", "other"}
    end.touch()
    assert not wait(tasks, timeout=30).not_done
    assert order.read_text().split()[-1] == "busy1"


def test_a_client_has_so_many_and_the_program_itself_any_number(pool: Pool, queue: TaskQueue, tmp_path: Path) -> None:
    with asking("busy"):
        running, _ = at_rest(queue, tmp_path / "running")
        tasks = [queue.schedule(in_worker.rest, (0.0,), 30.0) for _ in range(2)]
        with pytest.raises(TooMany, match=r"3 of your tasks .* ask again in 2 s") as refused:
            queue.schedule(in_worker.rest, (0.0,), 30.0)
        assert refused.value.retry_after_s == 2
        assert queue.answer(1.0)  # which is nobody's task
        other = pool.queue(1, 4 * GIB)  # where nobody is counted, as in that of the queue of fits
        tasks += [other.schedule(in_worker.rest, (0.0,), 30.0) for _ in range(4)]
    with asking(None):
        tasks += [queue.schedule(in_worker.rest, (0.0,), 30.0) for _ in range(5)]
    running.cancel()
    assert not wait(tasks, timeout=30).not_done
    with asking("busy"):
        assert queue.result(in_worker.rest, (0.0,), 30.0) is None


def test_no_client_holds_all_places_while_another_waits(tmp_path: Path) -> None:
    """Two queues of two places, a client whose four tasks of each kind take for ever, and two others who come later."""
    pool = Pool()
    queues = [pool.queue(2, 4 * GIB, 9) for _ in range(2)]
    files = [tmp_path / str(number) for number in range(8)]
    try:
        with asking("slow"):
            for number, file in enumerate(files):
                queues[number % 2].schedule(in_worker.sign_in_and_rest, (str(file), 600.0, 1), 900.0)
        until(lambda: sum(file.exists() for file in files) == 4, "two tasks in each queue")
        for client in ("one", "two"):
            with asking(client):
                assert [queue.result(in_worker.rest, (0.0,), 30.0) for queue in queues] == [None, None]
        assert sum(file.exists() for file in files) == 4
    finally:
        pool.stop()


# What is kept for a key


def test_a_key_keeps_its_process_and_shares_it_with_no_other(pool: Pool, queue: TaskQueue) -> None:
    other_queue = pool.queue(1, 3 * GIB)
    first, _ = ask(queue, "a", "one")
    second, of_second = ask(queue, "b", "two")
    assert ask(other_queue, "a", "three") == (first, ["one", "three"])
    assert other_queue.result(in_worker.describe, (), 30.0, "a")["memory"][0] == 3 * GIB
    assert first != second
    assert of_second == ["two"]
    assert ask(queue, None, "four")[1] == ["four"]


def test_a_task_does_not_wait_for_the_process_of_its_key(pool: Pool, tmp_path: Path) -> None:
    queue = pool.queue(2, 4 * GIB)
    first, _ = ask(queue, "a", "one")
    _, at_work = at_rest(queue, tmp_path / "running", "a")
    assert at_work == first
    second, words = ask(queue, "a", "two")
    assert (second != first, words) == (True, ["two"])


def test_the_one_that_was_not_asked_for_longest_makes_room(pool: Pool, queue: TaskQueue) -> None:
    first, _ = ask(queue, "a", "one")
    second, _ = ask(queue, "b", "one")
    ask(queue, "a", "two")
    ask(queue, "c", "one")
    assert pool.idle_keys == ["a", "c"]
    until(lambda: not is_alive(second), "the end of a process")
    assert ask(queue, "a", "three") == (first, ["one", "two", "three"])


def test_a_refusal_is_handed_on_and_the_process_stays(queue: TaskQueue) -> None:
    first, _ = ask(queue, "a", "one")
    with pytest.raises(BadScan, match="too small"):
        queue.result(in_worker.refuse, ("too small",), 30.0, "a")
    assert ask(queue, "a", "two") == (first, ["one", "two"])


@pytest.mark.parametrize("function", [in_worker.lose, in_worker.burn, in_worker.raise_what_cannot_travel])
def test_what_ends_a_task_badly_ends_its_process(pool: Pool, queue: TaskQueue, function: Callable[[], None]) -> None:
    first, _ = ask(queue, "a", "one")
    with pytest.raises((OSError, RuntimeError)):
        queue.result(function, (), 0.5, "a")
    assert not is_alive(first)
    assert pool.idle_keys == []
    assert ask(queue, "a", "two")[1] == ["two"]


def test_a_process_that_was_killed_while_it_rested_is_not_missed(queue: TaskQueue) -> None:
    first, _ = ask(queue, "a", "one")
    os.kill(first, signal.SIGKILL)
    assert ask(queue, "a", "two")[1] == ["two"]


def test_a_process_that_has_grown_large_is_ended() -> None:
    pool = Pool(most_idle=2, large_bytes=1)
    try:
        pid, _ = ask(pool.queue(1, 4 * GIB), "a", "one")
        assert not is_alive(pid)
        assert pool.idle_keys == []
    finally:
        pool.stop()


def test_a_process_that_was_not_asked_for_a_while_ends_itself() -> None:
    """In a process of its own, whose pipe says at once that nothing comes."""
    worker = execution.Worker("a")
    try:
        worker.call(execution.packed(in_worker.expire_soon, ()), 4 * GIB, 30.0)
        until(worker.has_ended, "the end of a process")
        with pytest.raises(execution.NotBegun):
            worker.call(execution.packed(in_worker.rest, (0.0,)), 4 * GIB, 30.0)
    finally:
        worker.end()


def test_dropping_a_key_ends_its_tasks_and_processes_and_leaves_others(pool: Pool, tmp_path: Path) -> None:
    queue = pool.queue(2, 4 * GIB)
    kept, _ = ask(queue, "b", "one")
    idle, _ = ask(queue, "a", "one")
    running = [at_rest(queue, tmp_path / name, "a") for name in ("first", "second")]
    waiting = queue.schedule(in_worker.rest, (0.0,), 30.0, "a")
    pool.drop("a")
    assert not any(is_alive(pid) for pid in (idle, *(pid for _, pid in running)))
    for task in (waiting, *(task for task, _ in running)):
        with pytest.raises(RuntimeError, match="was ended"):
            task.result(0)
    assert pool.idle_keys == ["b"]
    assert ask(queue, "b", "two") == (kept, ["one", "two"])
