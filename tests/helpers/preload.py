"""Has the fork server import the modules that it is given, and prints what a task then finds imported: a program."""

import json
import sys

import in_worker

from breastrig.execution.fork_server import preload
from breastrig.execution.processes import Processes

if __name__ == "__main__":
    import breastrig.core.round_robin  # noqa: F401  a module of the program that no task needs

    preload(sys.argv[1:])
    processes = Processes(1, memory_bytes=2**32)
    json.dump(processes.schedule(in_worker.describe, (), 30.0).result()["imported"], sys.stdout)
    processes.stop()
