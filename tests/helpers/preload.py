"""Has the fork server import the modules that it is given, and prints what a task then finds imported: a program."""

import json
import sys

import in_worker

from breastrig.execution.pool import Pool
from breastrig.execution.worker import preload

if __name__ == "__main__":
    import breastrig.core.documents  # noqa: F401  a module of the program that no task needs

    preload(sys.argv[1:])
    pool = Pool()
    json.dump(pool.queue(1, 2**32).result(in_worker.describe, (), 30.0)["imported"], sys.stdout)
    pool.stop()
