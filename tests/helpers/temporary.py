"""Temporary files of the tests in memory, where there is plenty of it.

A disk takes milliseconds to remove a folder, tens of them where it is busy, and tests remove thousands.
"""

import os
import tempfile
from pathlib import Path

MEMORY = Path("/dev/shm")
FREE, ALL = 6 * 2**30, 12 * 2**30  # bytes there, and of the machine; a run takes less than two


def keep_in_memory() -> None:
    """From now on, for this process and those that it starts; not where TMPDIR says another place."""
    if "TMPDIR" in os.environ or not os.access(MEMORY, os.W_OK):
        return
    place = os.statvfs(MEMORY)
    has_room = place.f_bavail * place.f_frsize >= FREE
    if has_room and os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") >= ALL and not place.f_flag & os.ST_NOEXEC:
        os.environ["TMPDIR"] = tempfile.tempdir = str(MEMORY)
