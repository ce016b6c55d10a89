"""The readers' processes shared between clients: turns, a cap for each, and no task that is lost."""

import threading
from collections.abc import Iterator
from concurrent.futures import CancelledError, wait
from contextlib import contextmanager
from pathlib import Path

import pytest
from helpers import in_worker
from helpers.waiting import until

from breastrig.core.errors import BadScan, TooMany
from breastrig.execution.client_key import client_key
from breastrig.execution.fair_processes import FairProcesses
from breastrig.execution.kept_processes import KeptProcesses
from breastrig.execution.processes import Processes
from breastrig.execution.warm_first import ForKey, WarmFirst

GIB = 2**30


@pytest.fixture
def readers() -> Iterator[FairProcesses]:
    readers = FairProcesses(Processes(1, memory_bytes=4 * GIB), waiting_per_client=3)
    readers.warm_up()
    yield readers
    readers.stop()


@contextmanager
def asking(client: str | None) -> Iterator[None]:
    before = client_key.set(client)
    try:
        yield
    finally:
        client_key.reset(before)


def test_a_client_with_one_task_does_not_wait_for_all_of_anothers(readers: FairProcesses, tmp_path: Path) -> None:
    file = str(tmp_path / "order")
    with asking("busy"):
        tasks = [readers.schedule(in_worker.wait_for, (str(tmp_path / "all asked"),), 30.0)]
        tasks += [readers.schedule(in_worker.note, (file, f"busy {number}"), 30.0) for number in range(2)]
    with asking("other"):
        tasks.append(readers.schedule(in_worker.note, (file, "other"), 30.0))
    (tmp_path / "all asked").touch()
    assert not wait(tasks, timeout=30).not_done
    order = (tmp_path / "order").read_text().split()
    assert order.index("other") < order.index("1")


def test_a_client_has_so_many_and_the_program_itself_any_number(readers: FairProcesses, tmp_path: Path) -> None:
    end = tmp_path / "end"
    with asking("busy"):
        tasks = [readers.schedule(in_worker.wait_for, (str(end),), 30.0) for _ in range(3)]
        with pytest.raises(TooMany, match=r"3 of your scans and reports .* ask again in 2 s"):
            readers.schedule(in_worker.rest, (0.0,), 30.0)
    with asking(None):
        tasks += [readers.schedule(in_worker.rest, (0.0,), 30.0) for _ in range(5)]
    end.touch()
    assert not wait(tasks, timeout=30).not_done
    with asking("busy"):
        assert readers.result(in_worker.describe, (), 30.0)["threads"] == [1]


def test_no_client_holds_all_readers_while_another_waits() -> None:
    """Two readers, a client whose four tasks of each kind take for ever, and two others who come later."""
    readers = FairProcesses(Processes(2, memory_bytes=4 * GIB, spare=2), waiting_per_client=9)
    readers.warm_up()
    upload = ForKey("a", in_worker.rest, begins=True)
    try:
        with asking("slow"):
            slow = [readers.schedule(kind, (60.0,), 90.0) for kind in (upload, in_worker.rest) for _ in range(4)]
        until(lambda: sum(task.inner is not None for task in slow) == 3, "two uploads and another task")
        for client in ("one", "two"):
            for kind in (upload, in_worker.rest):
                with asking(client):
                    assert readers.schedule(kind, (0.0,), 30.0).result(20.0) is None
        assert sum(task.inner is not None for task in slow) == 3
    finally:
        readers.stop()


@pytest.mark.parametrize("upload", [True, False])
def test_an_upload_and_all_else_do_not_wait_for_each_other(upload: bool) -> None:
    """Nor do more of them run than one beside each worker."""
    kept = KeptProcesses(4 * GIB, kept=4)
    cold = Processes(1, memory_bytes=4 * GIB, spare=1)
    readers = FairProcesses(WarmFirst(cold, kept, in_worker.call_as_kept, memory_bytes=4 * GIB), waiting_per_client=9)
    readers.warm_up()
    kinds = (ForKey("a", in_worker.rest, begins=True), in_worker.rest)
    first, second = kinds if upload else kinds[::-1]
    try:
        resting = [readers.schedule(first, (60.0,), 90.0) for _ in range(2)]
        until(lambda: resting[0].inner is not None, "a running task")
        assert readers.schedule(second, (0.0,), 30.0).result(30.0) is None
        assert [task.inner is not None for task in resting] == [True, False]
        assert not any(task.done() for task in resting)
    finally:
        readers.stop()


def test_errors_and_timeouts_come_to_whoever_asked(readers: FairProcesses) -> None:
    with pytest.raises(BadScan, match="no scan"):
        readers.result(in_worker.refuse, ("no scan",), 30.0)
    with pytest.raises(TimeoutError):
        readers.result(in_worker.rest, (60.0,), 0.2)
    assert readers.answer(10.0)


def test_a_cancelled_task_ends_whether_it_runs_or_waits(readers: FairProcesses, tmp_path: Path) -> None:
    file = tmp_path / "order"
    running = readers.schedule(in_worker.rest, (60.0,), 90.0)
    waiting = readers.schedule(in_worker.note, (str(file), "never"), 30.0)
    last = readers.schedule(in_worker.note, (str(file), "last"), 30.0)
    assert waiting.cancel()
    assert wait([waiting], timeout=10).done
    until(lambda: running.inner is not None, "a running task")
    running.cancel()
    assert not wait([running, last], timeout=30).not_done
    with pytest.raises(CancelledError):
        running.result()
    assert file.read_text() == "last\n"


def test_a_stop_ends_what_runs_and_what_waits(readers: FairProcesses) -> None:
    tasks = [readers.schedule(in_worker.rest, (60.0,), 90.0) for _ in range(3)]
    threading.Timer(0.1, readers.stop).start()
    assert not wait(tasks, timeout=30).not_done
    assert all(task.cancelled() or task.exception() is not None for task in tasks)
    with pytest.raises(RuntimeError, match="stopped"):
        readers.schedule(in_worker.rest, (0.0,), 30.0)
