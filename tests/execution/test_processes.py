import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from multiprocessing import forkserver
from pathlib import Path
from typing import Any

import pytest
from helpers import in_worker
from helpers.real_server import children
from helpers.waiting import until
from pebble import ProcessFuture

from breastrig.execution import processes as execution
from breastrig.execution.processes import Processes

GIB = 2**30


@pytest.fixture
def processes() -> Iterator[Processes]:
    processes = Processes(1, memory_bytes=4 * GIB, cpu_s=1)
    processes.warm_up()
    yield processes
    processes.stop()


def test_a_task_runs_alone_within_its_limits_and_with_one_thread(processes: Processes) -> None:
    first, second = (processes.schedule(in_worker.describe, (), 30.0).result() for _ in range(2))
    assert first["pid"] != second["pid"]
    assert (first["memory"], first["cpu"], first["core"]) == ((4 * GIB, 4 * GIB), (1, 6), (0, 0))
    assert first["threads"] == [1]
    assert first["garbage"] == (True, True)  # looked for, but not among the modules


def test_a_task_that_was_forgotten_on_the_way_is_asked_again(
    processes: Processes, monkeypatch: pytest.MonkeyPatch
) -> None:
    forgotten = ProcessFuture()
    answers = [forgotten]
    schedule = processes.schedule
    monkeypatch.setattr(execution, "ANSWER_S", 2.0)
    monkeypatch.setattr(processes, "schedule", lambda *a, **k: answers.pop() if answers else schedule(*a, **k))
    processes.warm_up()
    assert forgotten.cancelled()

    monkeypatch.setattr(execution, "ANSWER_S", 0.01)
    monkeypatch.setattr(processes, "schedule", lambda *_, **__: ProcessFuture())
    with pytest.raises(RuntimeError, match="No process answers"):
        processes.warm_up()


def answer_of_a_program(name: str, *words: str) -> Any:
    program = Path(in_worker.__file__).with_name(name)
    answer = subprocess.run(
        [sys.executable, str(program), *words], capture_output=True, text=True, check=False, timeout=120
    )
    assert (answer.returncode, answer.stderr) == (0, "")
    return json.loads(answer.stdout)


def imported_by_a_task(*named: str) -> set[str]:
    """The modules that a task finds, in a program that has imported breastrig.core.round_robin."""
    return set(answer_of_a_program("preload.py", *named))


def test_a_task_finds_imported_what_was_named_before_the_first_pool_and_nothing_else_of_the_program() -> None:
    found = imported_by_a_task("colorsys", "breastrig.core.units", "no_such_module")
    assert {"colorsys", "breastrig.core.units"} <= found
    assert "breastrig.core.round_robin" not in found


def test_a_task_finds_imported_all_that_the_program_has_when_nothing_was_named() -> None:
    assert "breastrig.core.round_robin" in imported_by_a_task()


def test_a_task_that_burns_the_processor_is_stopped_and_the_next_one_runs(processes: Processes) -> None:
    with pytest.raises(OSError, match="Abnormal termination"):
        processes.schedule(in_worker.burn, (), 30.0).result()
    assert processes.schedule(in_worker.describe, (), 30.0).result()["threads"] == [1]


def test_a_task_that_takes_too_long_is_stopped(processes: Processes) -> None:
    with pytest.raises(TimeoutError):
        processes.schedule(in_worker.rest, (60.0,), 0.2).result()


def test_the_task_after_the_first_finds_a_spare_process_ready() -> None:
    others = waiting_processes()  # of pools that other tests keep
    processes = Processes(1, memory_bytes=4 * GIB, spare=1)
    try:
        others.add(processes.schedule(in_worker.describe, (), 30.0).result()["pid"])
        until(lambda: len(waiting_processes() - others) == 2, "the processes to be ready")
        ready = waiting_processes() - others
        assert {processes.schedule(in_worker.describe, (), 30.0).result()["pid"] for _ in range(2)} == ready
    finally:
        processes.stop()


def waiting_processes() -> set[int]:
    """Not the fork server itself, which has no children either in the moment after they were killed."""
    server = forkserver._forkserver._forkserver_pid
    found = {pid for pid in children(os.getpid()) if not children(pid) and b"forkserver" in command(pid)}
    return found - {server}


def test_a_process_that_is_killed_while_it_waits_for_work_is_not_missed(processes: Processes) -> None:
    for _ in range(5):
        waiting = waiting_processes()
        for pid in waiting:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        assert processes.result(in_worker.describe, (), 30.0)["pid"] not in waiting


def command(pid: int) -> bytes:
    with suppress(OSError):
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    return b""


def test_stopping_kills_what_runs_and_takes_nothing_more() -> None:
    processes = Processes(1, memory_bytes=4 * GIB)
    future = processes.schedule(in_worker.rest, (60.0,), 60.0)
    until(future.running, "the task to run")
    processes.stop()
    with pytest.raises(RuntimeError, match="stopped"):
        processes.schedule(in_worker.rest, (0.0,), 1.0)


def test_stopping_while_a_process_starts_leaves_no_traceback() -> None:
    program = Path(in_worker.__file__).with_name("stop_early.py")
    answer = subprocess.run([sys.executable, str(program)], capture_output=True, text=True, check=False, timeout=120)
    assert (answer.returncode, answer.stderr) == (0, "")
