"""Worker processes that are kept: each for one key, so that what it has read once serves the next questions too.

The other pools end a process with its task, so that nothing of one patient is left for the next.  Here the same holds
of the key: a process serves one alone, and is ended when the key is dropped, when it was not asked for some minutes,
or when others are asked for and there are as many as may be, or when it has grown too large.  Then its memory is
gone, whatever was in it.

Questions wait for their answer (`result`); tasks that any process could do go to the key's one only while that rests
(`begin`).

Answers in the server's own threads were the other way: a hand that drags asks ten times a second, and would take the
interpreter from everybody else.
"""

import threading
import time
from collections.abc import Callable
from concurrent.futures import CancelledError, Future, wait
from contextlib import suppress
from pathlib import Path
from typing import Any

from breastrig.core.errors import BreastRigError, TooMany
from breastrig.execution.processes import Processes

KEPT = 4  # processes; each holds a scan and what was measured on it, some hundred megabytes at most on usual scans
IDLE_S = 300.0  # a surgeon who has moved nothing for so long waits the half second again
LOOK_EVERY_S = 15.0
WAITING = 4  # questions to one process, of as many tabs or people; a page has one under way
RETRY_S = 1
LARGE_BYTES = 800 * 2**20  # of memory at rest; a usual scan with colours leaves half of it
WEIGH_S = 10.0  # for a process to say how large it is
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

    def __init__(
        self,
        memory_bytes: int,
        kept: int = KEPT,
        idle_s: float = IDLE_S,
        large_bytes: int = LARGE_BYTES,
        ready: bool = False,
    ) -> None:
        """With `ready` a process that has done nothing yet stands by for the next key."""
        self._memory_bytes, self._most, self._idle_s, self._large_bytes = memory_bytes, kept, idle_s, large_bytes
        self._kept: dict[str, _Kept] = {}
        self._ending: list[tuple[str, _Kept]] = []  # no longer asked, to be ended by the thread
        self._to_weigh: list[tuple[str, _Kept]] = []
        self._blank: _Kept | None = None
        self._keeps_ready = ready
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
        assert kept is not None
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

    def begin(
        self, key: str, function: Callable[..., Any], args: tuple[Any, ...], timeout: float, new: bool = False
    ) -> "Future[Any] | None":
        """The future of `function(*args)` in the key's own process, as Processes.schedule gives it.

        None, and nothing begun, when that process is at work, or there is none and `new` is false or no place free.
        A process whose task is cancelled, lost or out of time is ended.
        """
        try:
            kept = self._taken(key, alone=True, new=new)
        except (TooMany, RuntimeError):
            return None
        if kept is None:
            return None
        try:
            future: Future[Any] = kept.processes.schedule(function, args, timeout)
        except RuntimeError:
            self._drop_lost(key, kept)
            return None
        future.add_done_callback(lambda ended: self._rests(key, kept, ended))
        return future

    def stand_ready(self) -> None:
        """Starts the process that stands by, where one is wanted and missing."""
        with self._changed:
            if self._stopped or not self._keeps_ready or self._blank is not None:
                return
            self._blank = _Kept(self._memory_bytes)
            blank = self._blank
        with suppress(OSError, RuntimeError):  # then its first task starts another
            blank.processes.schedule(resident_bytes, (), WEIGH_S)

    def drop(self, key: str) -> None:
        """Ends the key's process and waits until it is gone; questions under way end with a RuntimeError."""
        with self._changed:
            ended = [kept for other, kept in self._ending if other == key]
            kept = self._kept.pop(key, None)
        for each in (*ended, *([] if kept is None else [kept])):
            each.end()

    def _rests(self, key: str, kept: _Kept, ended: "Future[Any]") -> None:
        """A task that `begin` gave has ended.  In the pool's thread, so nothing is ended or scheduled here."""
        error = CancelledError() if ended.cancelled() else ended.exception()
        with self._changed:
            kept.asked -= 1
            kept.used_at = time.monotonic()
            if error is None or isinstance(error, BreastRigError):
                self._to_weigh.append((key, kept))
            else:
                self._let_go(key, kept)
            self._changed.notify_all()

    def _let_go(self, key: str, kept: _Kept) -> None:
        """Holding the lock: the process is asked nothing more, and ended soon."""
        if self._kept.get(key) is kept:
            del self._kept[key]
            self._ending.append((key, kept))

    def _drop_lost(self, key: str, kept: _Kept) -> None:
        with self._changed:
            if self._kept.get(key) is kept:
                del self._kept[key]
        kept.end()

    def stop(self) -> None:
        """Ends all of them, and takes no more questions."""
        with self._changed:
            self._stopped = True
            left = [*self._kept.values(), *(kept for _, kept in self._ending)]
            self._kept.clear()
            self._changed.notify_all()
        for kept in left:
            kept.end()
        if self._thread is not None:
            self._thread.join()
        if self._blank is not None:
            self._blank.end()

    def _taken(self, key: str, alone: bool = False, new: bool = True) -> _Kept | None:
        """The key's process, one more question under way; None when it is not to be had `alone`, or is not there."""
        with self._changed:
            if self._stopped:
                raise RuntimeError("the processes are stopped")
            kept = self._kept.get(key)
            if (kept is None and not new) or (kept is not None and alone and kept.asked):
                return None
            if kept is None:
                if len(self._kept) >= self._most:
                    longest = self._longest_idle()
                    self._let_go(longest, self._kept[longest])
                kept, self._blank = self._blank or _Kept(self._memory_bytes), None
                self._kept[key] = kept
                self._changed.notify_all()
            elif kept.asked >= WAITING:
                raise TooMany(f"Others are moving something on this scan already; ask again in {RETRY_S} s.", RETRY_S)
            kept.asked += 1
            if self._thread is None:
                self._thread = threading.Thread(target=self._end_idle, name="breastrig-kept", daemon=True)
                self._thread.start()
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
        """In the thread: ends what rests for long or was let go, weighs what has worked, keeps a blank one ready."""
        while True:
            with self._changed:
                self._changed.wait_for(self._has_work, min(LOOK_EVERY_S, self._idle_s))
                if self._stopped:
                    return
                long_ago = time.monotonic() - self._idle_s
                for key, kept in list(self._kept.items()):
                    if kept.asked == 0 and kept.used_at <= long_ago:
                        self._let_go(key, kept)
                ending, weighed, self._to_weigh = list(self._ending), self._to_weigh, []
            for each in ending:
                each[1].end()
                with self._changed, suppress(ValueError):
                    self._ending.remove(each)
            for key, kept in weighed:
                self._weigh(key, kept)
            self.stand_ready()

    def _has_work(self) -> bool:
        return self._stopped or bool(self._ending or self._to_weigh)

    def _weigh(self, key: str, kept: _Kept) -> None:
        """Has a process that rests say how large it is, and lets go of a large one when it rests then."""
        with self._changed:
            if self._kept.get(key) is not kept or kept.asked:
                return  # its next task is followed by this again
        try:
            asked = kept.processes.schedule(resident_bytes, (), WEIGH_S)
            while not wait([asked], ENDED_EVERY_S).done:
                if kept.is_ended or self._stopped:
                    return
            is_large = asked.result() > self._large_bytes
        except (CancelledError, OSError, RuntimeError, TimeoutError):
            is_large = True
        with self._changed:
            if is_large and kept.asked == 0:
                self._let_go(key, kept)


def resident_bytes() -> int:
    """Memory that this process has in use; 0 where the system does not say."""
    try:
        for line in Path("/proc/self/status").read_text(encoding="ascii", errors="replace").splitlines():
            if line.startswith("RssAnon:"):
                return int(line.split()[1]) * 1024
    except OSError:
        pass
    return 0
