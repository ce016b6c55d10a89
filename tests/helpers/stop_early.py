"""Stops pools at different moments of their processes' start: a program whose stderr must stay empty.

Prints the processes that are left, beside the fork server and its tracker.
"""

import json
import os
import sys
import time

import in_worker
from real_server import children

from breastrig.execution.pool import Pool

MOMENTS_S = [0.004 * step for step in range(12)]

if __name__ == "__main__":
    servers: set[int] = set()
    for moment in MOMENTS_S:
        pool = Pool(most_idle=1)
        queue = pool.queue(2, 2**32)
        queue.warm_up()
        tasks = [queue.schedule(in_worker.rest, (60.0,), 60.0, key) for key in ("a", "b", None)]
        time.sleep(moment)
        pool.stop()
        servers = servers or set(children(os.getpid()))
    json.dump(sorted(set(children(os.getpid())) - servers), sys.stdout)
