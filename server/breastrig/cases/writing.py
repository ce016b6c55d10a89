"""Writes a case: one writer at a time, each document whole or not at all, on the disk when the call returns.

A writer locks `.lock`, moves the folder's stamp, removes what killed writers have left, writes beside and renames. The
lock is the kernel's, of an opened descriptor: `filelock.FileLock` would make the folder of a deleted case again, and
falls back to locks that a killed process keeps. Locks follow `fork`: processes come from a fork server.
"""

import errno
import os
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from filelock import lock_descriptor

from breastrig.core.errors import Conflict, NotFound

LOCK, PART = ".lock", ".part-"
BUSY_S = 30.0  # far above the longest writing (a deletion with fifty versions takes one second)
LOOK_S = 0.002  # between two tries: a plan is written in some milliseconds
NONE_HERE = "There is no such patient; a case goes with its last scan."
BUSY = "Another program is writing into this case; try again in a moment."
FULL = (errno.ENOSPC, errno.EDQUOT)  # a disk has no room, or its user may have no more
CHANGED = "Somebody has changed this since you read it; read it again, take the change over, and send it again."


class Changed(Conflict):
    """The document differs from the one that the writer has seen; `etag` is that of the present one."""

    def __init__(self, etag: str) -> None:
        super().__init__(CHANGED)
        self.etag = etag

    def __reduce__(self) -> tuple[type["Changed"], tuple[str]]:
        return Changed, (self.etag,)


@contextmanager
def locked(folder: Path, wait_s: float = BUSY_S) -> Iterator[None]:
    """Holds the case of that folder, waiting for who has it.  Raises NotFound when it is gone, Conflict when busy."""
    descriptor = _locked(folder, time.monotonic() + wait_s)
    try:
        yield
    finally:
        os.close(descriptor)


def _locked(folder: Path, deadline: float) -> int:
    file = folder / LOCK
    while True:
        try:
            descriptor = os.open(file, os.O_RDWR | os.O_CREAT | getattr(os, "O_CLOEXEC", 0), 0o600)
        except (FileNotFoundError, NotADirectoryError) as error:
            raise NotFound(NONE_HERE) from error
        try:
            while not lock_descriptor(descriptor, blocking=False):
                if time.monotonic() > deadline:
                    raise Conflict(BUSY)
                time.sleep(LOOK_S)
            if _is_still(descriptor, file):
                return descriptor
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)  # the folder was deleted or moved while this waited


def _is_still(descriptor: int, file: Path) -> bool:
    """Whether the locked file still has its name."""
    try:
        named = file.stat()
    except FileNotFoundError:
        return False
    held = os.fstat(descriptor)
    return (held.st_dev, held.st_ino) == (named.st_dev, named.st_ino)


def stamp_of(folder: Path) -> int:
    """The time of the last write to the case, ns: another number after each change."""
    return folder.stat().st_mtime_ns


def move_stamp(folder: Path, before: int) -> int:
    """Sets the folder's time strictly above `before`; the kernel's own coarse clock steps back."""
    stamp = max(time.time_ns(), before + 1)
    os.utime(folder, ns=(stamp, stamp))
    return stamp


@contextmanager
def writing(folder: Path, wait_s: float = BUSY_S) -> Iterator[None]:
    """Holds the case for changes inside the block, which readers of the stamp will notice.  Raises as `locked`."""
    with locked(folder, wait_s):
        before = move_stamp(folder, stamp_of(folder))
        for part in folder.glob(f"{PART}*"):  # of killed writers: this one alone writes now
            part.unlink(missing_ok=True)
        try:
            yield
        finally:
            with suppress(FileNotFoundError):  # the block has deleted the case
                move_stamp(folder, before)


def put(folder: Path, name: str, content: bytes) -> None:
    """Replaces the file `name` below the case's folder, whole or not at all; it is on the disk at the end.

    Raises OSError; then the file is as it was.
    """
    descriptor, part = tempfile.mkstemp(prefix=PART, dir=folder)  # 0600
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        replace(Path(part), folder / name)
    except BaseException:
        with suppress(OSError):
            os.unlink(part)
        raise
    sync_folder((folder / name).parent)


def replace(source: Path, target: Path) -> None:
    """`os.replace`, tried again for a while where another program has the target open, as Windows refuses it."""
    deadline = time.monotonic() + 1.0
    while True:
        try:
            os.replace(source, target)
            return
        except PermissionError:
            if os.name != "nt" or time.monotonic() > deadline:
                raise
            time.sleep(LOOK_S)


def sync_folder(folder: Path) -> None:
    """Syncs the names in the folder to the disk; Windows has no such call."""
    if os.name == "nt":
        return
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
