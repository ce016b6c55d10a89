"""What a test asks a worker process to do; imported there by name."""

import os
import resource
import sys
import time

from threadpoolctl import threadpool_info


def describe() -> dict[str, object]:
    """Limits and state of the process that runs this."""
    return {
        "pid": os.getpid(),
        "memory": resource.getrlimit(resource.RLIMIT_AS),
        "cpu": resource.getrlimit(resource.RLIMIT_CPU),
        "core": resource.getrlimit(resource.RLIMIT_CORE),
        "threads": sorted({pool["num_threads"] for pool in threadpool_info()}),
        "imported": "breastrig.jobs.run_fit" in sys.modules,
    }


def burn() -> None:
    """Uses the processor without end."""
    while True:
        pass


def rest(seconds: float) -> None:
    time.sleep(seconds)
