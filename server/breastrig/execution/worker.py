"""One process that executes tasks, and the pipe to it: `Worker` is this side, `_serve` the other.

Processes fork from multiprocessing's fork server, which has imported once what most tasks need; so a new one is there
within hundredths of a second.  Calls and answers travel as bytes, each pickled on its own, so that what cannot be
pickled fails its own task only.
"""

import gc
import logging
import multiprocessing
import os
import pickle
import resource
import signal
import threading
import traceback
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import forkserver, resource_tracker
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from breastrig.core.errors import BreastRigError
from breastrig.core.log_lines import set_up_logs_from_environment
from breastrig.core.scratch import sweep_scratch

START_S = 60.0  # for the fork server to import everything, on a slow machine
IDLE_S = 300.0  # a process that is asked nothing for so long ends itself, and its memory is gone
BEGUN = b""
SWEEP_S = 5.0  # how long a killed process's folder stays at most, where nobody else makes one
DIED = "The process of this task ended unexpectedly."

log = logging.getLogger(__name__)

_context = multiprocessing.get_context("forkserver")
_preloaded = [
    "__main__",
    "breastrig.execution.worker",
    "numpy",
    "scipy.linalg",
]  # whose threads are limited before a task


def preload(modules: Iterable[str]) -> None:
    """Has the fork server import these modules, those that are installed; before the first process."""
    _preloaded.extend(name for name in modules if name not in _preloaded)


def start_fork_server() -> None:
    """Starts it, if it does not run, with SIGINT blocked: Ctrl-C on a terminal goes to every process of it, and is
    this program's to answer."""
    _context.set_forkserver_preload(_preloaded)
    resource_tracker.ensure_running()  # its start would let the signal through again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        forkserver.ensure_running()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def scratch_swept() -> Iterator[None]:
    """For whoever starts and kills processes: sweeps every few seconds until the block ends, and then once more."""
    over = threading.Event()

    def sweep_on() -> None:
        while not over.wait(SWEEP_S):
            try:
                sweep_scratch()
            except Exception:
                log.exception("scratch folders cannot be swept")

    thread = threading.Thread(target=sweep_on, name="breastrig-scratch", daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
        sweep_scratch()


class NotBegun(Exception):
    """The process had ended, or did not answer, before it began the task: another one may have it."""


@dataclass(frozen=True)
class Answer:
    """The outcome of a call: its result, or the exception that it raised."""

    value: Any
    error: Exception | None = None
    resident_bytes: int = 0  # memory that the process has in use

    def result(self) -> Any:
        if self.error is not None:
            raise self.error
        return self.value


class Worker:
    """One owner calls and ends it; any thread may `kill` it."""

    def __init__(self, key: str | None = None) -> None:
        self.key = key
        start_fork_server()
        self._pipe, theirs = _context.Pipe()
        self._process = _context.Process(target=_serve, args=(theirs,), daemon=True)
        self._process.start()
        theirs.close()

    def call(self, call: bytes, memory_bytes: int, timeout: float) -> Answer:
        """The answer of a `packed` call.  Raises NotBegun, TimeoutError, or OSError when the process died."""
        try:
            self._pipe.send_bytes(pickle.dumps((call, memory_bytes)))
            self._receive(START_S)
        except (EOFError, OSError) as error:
            raise NotBegun from error
        try:
            return unpacked(self._receive(timeout))
        except TimeoutError:
            raise
        except (EOFError, OSError) as error:
            raise OSError(DIED) from error

    def has_ended(self) -> bool:
        return not self._process.is_alive()

    def kill(self) -> None:
        self._process.kill()

    def end(self) -> None:
        """Kills it and waits until it is gone."""
        self._process.kill()
        self._process.join()
        self._pipe.close()

    def _receive(self, timeout: float) -> bytes:
        if not wait([self._pipe, self._process.sentinel], timeout):
            raise TimeoutError
        if not self._pipe.poll():  # a child of the process may still have the other end
            raise EOFError
        return self._pipe.recv_bytes()


def packed(function: Callable[..., Any], args: tuple[Any, ...]) -> bytes:
    """A call as bytes, for `answered`."""
    return pickle.dumps((function, args), protocol=pickle.HIGHEST_PROTOCOL)


def answered(call: bytes) -> bytes:
    """Calls, and packs the answer.  An exception that cannot be pickled travels as its text."""
    try:
        function, args = pickle.loads(call)
        return pickle.dumps(Answer(function(*args), None, _resident_bytes()), protocol=pickle.HIGHEST_PROTOCOL)
    except Exception as error:
        if not isinstance(error, BreastRigError):
            error.add_note("".join(traceback.format_exception(error)))
        try:
            answer = pickle.dumps(Answer(None, error))
            pickle.loads(answer)
        except Exception:
            return pickle.dumps(Answer(None, RuntimeError(f"{type(error).__name__}: {error}")))
        return answer


def unpacked(answer: bytes) -> Answer:
    """The answer that `answered` has packed. RuntimeError when it was another version."""
    try:
        found: Answer = pickle.loads(answer)
    except Exception as error:
        raise RuntimeError(
            "A task's result cannot be read here; client and workers must be the same version."
        ) from error
    return found


def _serve(pipe: Any) -> None:
    """In the child: answers until the pipe is closed or nothing comes."""
    gc.freeze()  # what is imported lasts as long as the process, so it need not be looked through
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # a core dump would hold a patient's scan
    set_up_logs_from_environment()
    threading.Thread(target=_end_with_parent, daemon=True).start()
    threadpool_limits(1)  # more are slower at this size, and fits would fight over the cores
    with suppress(EOFError, OSError):
        while pipe.poll(IDLE_S):
            call, memory_bytes = pickle.loads(pipe.recv_bytes())
            pipe.send_bytes(BEGUN)
            _, most = resource.getrlimit(resource.RLIMIT_AS)
            resource.setrlimit(resource.RLIMIT_AS, (memory_bytes, most))
            pipe.send_bytes(answered(call))


def _end_with_parent() -> None:
    """A program that is killed cannot end its processes; each one notices by itself."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _resident_bytes() -> int:
    """0 where the system does not say."""
    with suppress(OSError):
        for line in Path("/proc/self/status").read_text(encoding="ascii", errors="replace").splitlines():
            if line.startswith("RssAnon:"):
                return int(line.split()[1]) * 1024
    return 0
