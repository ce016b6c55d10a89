"""The server from outside: memory and threads of its processes, and the moment at which each event is stored."""

import sqlite3
import threading
import time
from dataclasses import dataclass
from pathlib import Path

from helpers.real_server import children

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
    """Notes when each event becomes visible in the database to other processes."""

    def __init__(self, database: Path) -> None:
        super().__init__(daemon=True)
        self.moments: dict[tuple[str, int], float] = {}  # (fit, number of the event) -> time.perf_counter()
        self._database = database
        self._over = threading.Event()

    def run(self) -> None:
        connection = sqlite3.connect(f"file:{self._database}?mode=ro", uri=True, timeout=30)
        position = 0
        while not self._over.is_set():
            rows = connection.execute("SELECT position, fit, number FROM events WHERE position > ?", (position,))
            found = rows.fetchall()
            now = time.perf_counter()
            for last, fit, number in found:
                self.moments[fit, number] = now
                position = last
            self._over.wait(LOOK_EVERY_S)
        connection.close()

    def stop(self) -> None:
        self._over.set()
        self.join()
