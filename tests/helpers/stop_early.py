"""Stops pools at different moments of a replacement's start: run as a program, whose stderr must stay empty."""

import time

from breastrig.execution.processes import Processes

MOMENTS_S = [0.012 * step for step in range(12)]  # Pebble looks for replacements every 0.1 s

if __name__ == "__main__":
    for moment in MOMENTS_S:
        processes = Processes(2, memory_bytes=2**32)
        processes.warm_up()  # uses one process up, so that a replacement is due
        time.sleep(moment)
        processes.stop()
