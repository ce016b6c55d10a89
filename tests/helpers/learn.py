"""Has one task import what the fork server has not, and prints what later tasks find imported of it: a program."""

import json
import sys

import in_worker

from breastrig.execution.fork_server import preload
from breastrig.execution.processes import Processes

TASKS = 50  # one or two processes wait already when the server is told; a machine that is busy has it learn later

if __name__ == "__main__":
    wanted = sys.argv[1:]
    preload(["breastrig.core.units"])
    processes = Processes(1, memory_bytes=2**32)

    def found() -> list[str]:
        imported = processes.schedule(in_worker.describe, (), 30.0).result()["imported"]
        return [name for name in wanted if name in imported]

    before = found()
    processes.schedule(in_worker.need, tuple(wanted), 30.0).result()
    after = [found()]
    while len(after) < TASKS and not after[-1]:
        processes.schedule(in_worker.rest, (0.1,), 30.0).result()
        after.append(found())
    json.dump([before, after[-1]], sys.stdout)
    processes.stop()
