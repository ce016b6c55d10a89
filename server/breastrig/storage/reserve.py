"""Space that is set aside, so that a full disk does not keep anybody from deleting.

Deleting rows writes first: SQLite's log grows by every page that it changes.  So a file in the data folder holds space
for that, and gives it up a part at a time when a deletion finds none; it is filled again when there is space.
"""

import logging
import os
import shutil
import threading
from pathlib import Path

BYTES = 8 * 2**20  # the log holds 4 MB before it is emptied, and emptying it may make the database larger by as much
SHARE = 8  # of a small disk at most one part in so many
STEP = 2**19  # given up at once; others may fill what is given up, so not all of it
BLOCK = 2**16

log = logging.getLogger(__name__)


class Reserve:
    """One file.  May be used from any thread, by one process at a time."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._lock = threading.Lock()
        self._given_up = 0  # bytes

    def release(self) -> bool:
        """Gives up a part; False when nothing was left."""
        with self._lock:
            size = self._size()
            if size == 0:
                return False
            part = min(STEP, size)
            os.truncate(self._file, size - part)
            self._given_up += part
            return True

    def refill(self) -> None:
        """Takes back what was given up, and of what is lacking besides no more than half of what is free."""
        with self._lock:
            try:
                size = self._size()
                disk = shutil.disk_usage(self._file.parent)
                back = min(self._given_up, disk.free)
                target = min(BYTES, disk.total // SHARE, size + back + (disk.free - back) // 2)
                if target - size >= BLOCK:
                    self._grow(size, target)
                self._given_up = 0
            except OSError as error:
                log.warning("no space can be set aside for deleting (%s)", error.strerror)

    def _size(self) -> int:
        try:
            return self._file.stat().st_size
        except FileNotFoundError:
            return 0

    def _grow(self, size: int, target: int) -> None:
        """With random bytes, which no file system can keep in less space."""
        descriptor = os.open(self._file, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)
        try:
            while size < target:
                size += os.write(descriptor, os.urandom(min(BLOCK, target - size)))
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
