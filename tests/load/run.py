"""One run: a server as a process of its own, the clients and viewers in this one."""

import asyncio
import json
import math
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter

from breastrig.core.assets import asset_folder
from load.clients import work
from load.measured import Measured
from load.slow import Kept, SlowClients, allow_files, start
from load.viewers import Stage, view
from load.watched import Footprint, StoredEvents, footprint

SETTLE_S = 60.0  # at the end whatever is under way is let finish


@dataclass(frozen=True)
class Result:
    measured: Measured
    seconds: float
    memory: list[tuple[float, Footprint]]  # (s since the start, what the server used)
    exit_status: int
    log: str
    slow: dict[str, Kept]  # at the end of the run, by kind


def run(
    seconds: float, clients: int, viewers: int, slow: SlowClients | None = None, enough_fits: float = math.inf
) -> Result:
    """`breastrig serve` with the packaged model and the example patient, on a port and a data folder of its own.

    It ends before its time when clients have had `enough_fits` and viewers a whole stream, some of it live.
    """
    slow = slow or SlowClients()
    allow_files(slow.total + 1000)
    with tempfile.TemporaryDirectory() as folder:
        data, log = Path(folder, "data"), Path(folder, "log")
        with log.open("w") as errors:
            server = subprocess.Popen(
                [sys.executable, "-m", "breastrig.cli.main", "serve", "--no-token", "--port", "0", "--data", str(data)],
                stdout=subprocess.PIPE,
                stderr=errors,
                text=True,
            )
        assert server.stdout is not None
        try:
            found = re.search(r"http://[^:]+:(\d+)/", server.stdout.readline())
            assert found, log.read_text()
            stored = StoredEvents(data)
            stored.start()
            try:
                measured, took, memory, kept = asyncio.run(
                    _all(int(found[1]), server.pid, seconds, clients, viewers, slow, stored, enough_fits)
                )
            finally:
                stored.stop()
            server.terminate()
            status = server.wait(timeout=60)
        finally:
            server.kill()
            server.wait()
            server.stdout.close()
        return Result(measured, took, memory, status, log.read_text(), kept)


async def _all(
    port: int,
    pid: int,
    seconds: float,
    clients: int,
    viewers: int,
    slow: SlowClients,
    stored: StoredEvents,
    enough_fits: float,
) -> tuple[Measured, float, list[tuple[float, Footprint]], dict[str, Kept]]:
    folder = asset_folder("example") / "standing"
    scan = (folder / "scan.ply").read_bytes()
    landmarks = json.loads((folder / "landmarks.json").read_text(encoding="utf-8"))["landmarks"]
    stage = Stage(port, Measured(), asyncio.Event())
    async with asyncio.TaskGroup() as tasks:
        slowly, slow_tasks = start(tasks, port, slow)
        await slowly.settled()
        memory = [(0.0, footprint(pid))]
        began = perf_counter()
        for _ in range(clients):
            tasks.create_task(work(stage, scan, landmarks))
        for seed in range(viewers):
            tasks.create_task(view(stage, seed))
        measured = stage.measured
        while (now := perf_counter() - began) < seconds and not (
            measured.fits >= enough_fits and measured.streams_read and _late_s(stage, stored)
        ):
            await asyncio.sleep(min(1.0, seconds - now))
            stage.measured.open_streams.append(stage.streams)
            memory.append((perf_counter() - began, footprint(pid)))
        kept = {kind: replace(one) for kind, one in slowly.kinds.items()}
        stage.over.set()
        for task in slow_tasks:
            task.cancel()
        await asyncio.sleep(0)
    took = perf_counter() - began
    stage.measured.late_s += _late_s(stage, stored)
    memory.append((took, footprint(pid)))
    return stage.measured, took, memory, kept


def _late_s(stage: Stage, stored: StoredEvents) -> list[float]:
    """How long after it was stored each event reached a viewer who was waiting for it."""
    return [
        max(0.0, moment - stored.moments[fit, number])
        for fit, number, moment, opened in stage.received
        if stored.moments.get((fit, number), 0.0) > opened  # the others had been stored before anyone asked
    ]
