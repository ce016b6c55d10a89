"""The server from outside: memory and threads of its processes, and the moment at which each event is stored."""

import threading
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from helpers.real_server import children

from breastrig.cases.layout import CASES, FITS, LOG, SCANS

LOOK_EVERY_S = 0.002  # so exact are the moments


@dataclass(frozen=True)
class Footprint:
    server_mb: float  # resident memory of the server itself
    tree_mb: float  # of all its processes together; pages that they share are counted once (PSS)
    threads: int  # of the server itself
    processes: int


def footprint(pid: int) -> Footprint:
    status = dict(line.split(":", 1) for line in Path(f"/proc/{pid}/status").read_text().splitlines())
    below = children(pid)
    shares = [_share_kb(one) for one in (pid, *below)]
    return Footprint(int(status["VmRSS"].split()[0]) / 1000, sum(shares) / 1000, int(status["Threads"]), len(shares))


def _share_kb(pid: int) -> int:
    try:
        for line in Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines():
            if line.startswith("Pss:"):
                return int(line.split()[1])
    except OSError:  # it has ended
        pass
    return 0


class StoredEvents(threading.Thread):
    """Notes when each event becomes visible in the data folder to other processes."""

    def __init__(self, data: Path) -> None:
        super().__init__(daemon=True)
        self.moments: dict[tuple[str, int], float] = {}  # (fit, number of the event) -> time.perf_counter()
        self._data = data
        self._over = threading.Event()

    def run(self) -> None:
        read: dict[str, tuple[int, int]] = {}  # fit -> (bytes of whole lines, how many lines) of its log
        while not self._over.is_set():
            for log in self._data.glob(f"{CASES}/*/{SCANS}/*/{FITS}/*/{LOG}"):
                fit = log.parent.name
                size, lines = read.get(fit, (0, 0))
                with suppress(FileNotFoundError), log.open("rb") as file:  # deleted meanwhile
                    file.seek(size)
                    whole, newline, _ = file.read().rpartition(b"\n")
                    now = time.perf_counter()
                    come = whole.count(b"\n") + len(newline)
                    self.moments |= {(fit, number): now for number in range(lines + 1, lines + come + 1)}
                    read[fit] = size + len(whole) + len(newline), lines + come
            self._over.wait(LOOK_EVERY_S)

    def stop(self) -> None:
        self._over.set()
        self.join()
