"""Sweeping the folders of killed processes, for as long as a program runs that starts and kills some."""

import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from breastrig.core.scratch import sweep_scratch

SWEEP_S = 5.0  # how long a killed process's folder stays at most, where nobody else makes one

log = logging.getLogger(__name__)


@contextmanager
def scratch_swept() -> Iterator[None]:
    """For whoever starts and kills processes: sweeps every few seconds until the block ends, and then once more."""
    over = threading.Event()

    def sweep_on() -> None:
        while not over.wait(SWEEP_S):
            try:
                sweep_scratch()
            except Exception:
                log.exception("scratch folders cannot be swept")

    thread = threading.Thread(target=sweep_on, name="breastrig-scratch", daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
        sweep_scratch()
