"""A process that fits when told: `fit_worker.py SCAN`, then a number of seconds a line on its input.

Answers "ready", then for each line what each fit within that time took, [seconds, seconds of the processor], as JSON.
One BLAS thread, as in the service.
"""

import json
import sys
import time
from pathlib import Path

from helpers.example_fit import example_task
from threadpoolctl import threadpool_limits

from breastrig.fitting.fit import fit_iterates


def main() -> None:
    task = example_task(Path(sys.argv[1]))
    list(fit_iterates(task))
    answer("ready")
    for line in sys.stdin:
        times, end = [], time.perf_counter() + float(line)
        while (began := time.perf_counter()) < end:
            worked = time.process_time()
            list(fit_iterates(task))
            times.append((time.perf_counter() - began, time.process_time() - worked))
        answer(times)


def answer(what: object) -> None:
    sys.stdout.write(json.dumps(what) + "\n")
    sys.stdout.flush()


with threadpool_limits(limits=1):
    main()
