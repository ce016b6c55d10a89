"""Worker processes that are kept: each for one key, so that what it has read once serves the next questions too.

The other pools end a process with its task, so that nothing of one patient is left for the next.  Here the same holds
of the key: a process serves one alone, and is ended when the key is dropped, when it was not asked for some minutes,
or when others are asked for and there are as many as may be.  Then its memory is gone, whatever was in it.

Answers in the server's own threads were the other way: a hand that drags asks ten times a second, and would take the
interpreter from everybody else.
"""

import threading
import time
from collections.abc import Callable
from concurrent.futures import CancelledError, wait
from typing import Any

from breastrig.core.errors import TooMany
from breastrig.execution.processes import Processes

KEPT = 4  # processes; each holds a scan and what was measured on it, some hundred megabytes at most on usual scans
IDLE_S = 300.0  # a surgeon who has moved nothing for so long waits the half second again
LOOK_EVERY_S = 15.0
WAITING = 4  # questions to one process, of as many tabs or people; a page has one under way
RETRY_S = 1
ENDED_EVERY_S = 0.5  # how soon a question notices that its process was ended before it began


class _Kept:
    """One process and who uses it."""

    def __init__(self, memory_bytes: int) -> None:
        self.processes = Processes(1, memory_bytes=memory_bytes, tasks_each=0)
        self.asked = 0  # questions under way
        self.used_at = time.monotonic()
        self.is_ended = False

    def end(self) -> None:
        self.processes.stop()
        self.is_ended = True


class KeptProcesses:
    """May be called from any thread."""

    def __init__(self, memory_bytes: int, kept: int = KEPT, idle_s: float = IDLE_S) -> None:
        self._memory_bytes, self._most, self._idle_s = memory_bytes, kept, idle_s
        self._kept: dict[str, _Kept] = {}
        self._changed = threading.Condition()
        self._stopped = False
        self._thread: threading.Thread | None = None

    def __len__(self) -> int:
        with self._changed:
            return len(self._kept)

    def asked(self, key: str) -> int:
        """How many questions to the key's process are under way."""
        with self._changed:
            return self._kept[key].asked if key in self._kept else 0

    def result(self, key: str, function: Callable[..., Any], args: tuple[Any, ...], timeout: float) -> Any:
        """What `function(*args)` returns or raises in the key's own process, started when there is none.

        Raises TooMany when as many as may are asking, TimeoutError, and OSError or RuntimeError when the process was
        lost; then the next question starts another one.
        """
        kept = self._taken(key)
        try:
            future = kept.processes.schedule(function, args, timeout)
            while not wait([future], ENDED_EVERY_S).done:
                if kept.is_ended:  # a pool that stops may forget what it was about to begin
                    raise RuntimeError("the process was ended")
            return future.result()
        except CancelledError as error:
            raise RuntimeError("the process was ended") from error
        except (OSError, RuntimeError, TimeoutError):
            self._drop_lost(key, kept)
            raise
        finally:
            with self._changed:
                kept.asked -= 1
                kept.used_at = time.monotonic()

    def drop(self, key: str) -> None:
        """Ends the key's process and waits until it is gone; questions under way end with a RuntimeError."""
        with self._changed:
            kept = self._kept.pop(key, None)
        if kept is not None:
            kept.end()

    def _drop_lost(self, key: str, kept: _Kept) -> None:
        with self._changed:
            if self._kept.get(key) is kept:
                del self._kept[key]
        kept.end()

    def stop(self) -> None:
        """Ends all of them, and takes no more questions."""
        with self._changed:
            self._stopped = True
            left = list(self._kept)
            self._changed.notify_all()
        for key in left:
            self.drop(key)
        if self._thread is not None:
            self._thread.join()

    def _taken(self, key: str) -> _Kept:
        """The key's process, one more question under way."""
        ended = None
        with self._changed:
            if self._stopped:
                raise RuntimeError("the processes are stopped")
            kept = self._kept.get(key)
            if kept is None:
                if len(self._kept) >= self._most:
                    ended = self._kept.pop(self._longest_idle())
                kept = self._kept[key] = _Kept(self._memory_bytes)
            elif kept.asked >= WAITING:
                raise TooMany(f"Others are moving something on this scan already; ask again in {RETRY_S} s.", RETRY_S)
            kept.asked += 1
            if self._thread is None:
                self._thread = threading.Thread(target=self._end_idle, name="breastrig-kept", daemon=True)
                self._thread.start()
        if ended is not None:
            ended.end()
        return kept

    def _longest_idle(self) -> str:
        idle = {key: kept.used_at for key, kept in self._kept.items() if kept.asked == 0}
        if not idle:
            raise TooMany(
                f"Patterns or landmarks are being moved on {self._most} scans, as many as may be at once; "
                f"ask again in {RETRY_S} s.",
                RETRY_S,
            )
        return min(idle, key=lambda key: idle[key])

    def _end_idle(self) -> None:
        while True:
            with self._changed:
                if self._changed.wait_for(lambda: self._stopped, min(LOOK_EVERY_S, self._idle_s)):
                    return
                long_ago = time.monotonic() - self._idle_s
                old = [key for key, kept in self._kept.items() if kept.asked == 0 and kept.used_at <= long_ago]
                ended = [self._kept.pop(key) for key in old]
            for kept in ended:
                kept.end()
