"""Temporary files of the tests in memory, where there is plenty of it; as a program it prints the folder.

A disk takes milliseconds to remove a folder, tens of them where it is busy, and tests remove thousands.
"""

import os
import sys
import tempfile
from pathlib import Path

MEMORY = Path("/dev/shm")
FREE, ALL = 6 * 2**30, 12 * 2**30  # bytes there, and of the machine; a run takes less than two


def temporary_folder() -> str:
    """In memory if there is room for it and TMPDIR says no other place."""
    if "TMPDIR" in os.environ or not os.access(MEMORY, os.W_OK):
        return tempfile.gettempdir()
    place = os.statvfs(MEMORY)
    has_room = place.f_bavail * place.f_frsize >= FREE
    has_room = has_room and os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") >= ALL
    return str(MEMORY) if has_room and not place.f_flag & os.ST_NOEXEC else tempfile.gettempdir()


def keep_in_memory() -> None:
    """From now on, for this process and those that it starts."""
    os.environ["TMPDIR"] = tempfile.tempdir = temporary_folder()


if __name__ == "__main__":
    sys.stdout.write(temporary_folder())
