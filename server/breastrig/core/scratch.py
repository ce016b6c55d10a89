"""Folders for a moment, which do not outlive the process that made them, even if it is killed.

What is in them shows patients.  A killed process cannot tidy up, so each folder is locked by its process, and
whoever comes next on this machine removes those that nobody holds.
"""

import fcntl
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from breastrig.core.errors import BadSettings


@contextmanager
def scratch_folder() -> Iterator[Path]:
    """An empty folder, removed at the end of the block."""
    sweep_scratch()
    folder, lock = _made()
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        os.close(lock)


def sweep_scratch() -> None:
    """Removes the folders of processes that were killed."""
    for folder in _base().iterdir():
        with suppress(OSError):  # another one sweeps as well, or it is held
            lock = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                shutil.rmtree(folder, ignore_errors=True)
            finally:
                os.close(lock)


def _made() -> tuple[Path, int]:
    """A new folder, and the handle that locks it."""
    while True:
        folder = Path(tempfile.mkdtemp(dir=_base()))
        with suppress(FileNotFoundError):  # swept between making and locking
            lock = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
            fcntl.flock(lock, fcntl.LOCK_EX)
            if folder.is_dir():
                return folder, lock
            os.close(lock)


def _base() -> Path:
    """One folder for all processes of this user, which nobody else can look into."""
    base = Path(tempfile.gettempdir()) / f"breastrig-{os.getuid()}"
    with suppress(FileExistsError):
        base.mkdir(mode=0o700)
    facts = base.lstat()
    if facts.st_uid != os.getuid() or facts.st_mode & 0o077 or base.is_symlink():
        raise BadSettings(f"{base} is not this user's own; remove it, or set TMPDIR to another folder.")
    return base
