"""Temporary folders that do not outlive the process that made them, even if it is killed.

Their contents show patients. A killed process cannot clean up, so beside each folder is a file that its process keeps
locked, and the next process on this machine removes the folders whose file is not locked.
"""

import os
import secrets
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Optional

if TYPE_CHECKING:
    from filelock import FileLock

LOCK = ".lock"  # behind the folder's name


@contextmanager
def scratch_folder() -> Iterator[Path]:
    """An empty folder that nobody else can look into, removed at the end of the block."""
    sweep_scratch()
    with locked_folder(_base(), "") as folder:
        yield folder


def sweep_scratch() -> None:
    """Removes the folders of processes that were killed."""
    for base in _bases():
        remove_abandoned(base, "")


@contextmanager
def locked_folder(parent: Path, prefix: str) -> Iterator[Path]:
    """A new private folder inside the parent, its name beginning with the prefix; removed at the end of the block."""
    while True:
        folder = parent / f"{prefix}{secrets.token_hex(8)}"
        if (lock := _locked(folder)) is not None:  # else a sweep of another process has just looked at it
            break
    try:
        folder.mkdir(mode=0o700)
        yield folder
    finally:
        _remove(folder, lock)


def remove_abandoned(parent: Path, prefix: str) -> None:
    """Removes the locked folders of this prefix whose process was killed."""
    folders = {each.with_name(each.name.removesuffix(LOCK)) for each in parent.glob(f"{prefix}*")}
    for folder in folders:
        with suppress(OSError):  # another process removes it as well
            if (lock := _locked(folder)) is not None:
                _remove(folder, lock)


def _locked(folder: Path) -> Optional["FileLock"]:
    """The lock of the folder; None where another process holds it."""
    from filelock import FileLock, Timeout  # and asyncio with it: only what keeps a folder waits for them

    lock = FileLock(f"{folder}{LOCK}", mode=0o600)
    try:
        lock.acquire(blocking=False)
    except Timeout:
        return None
    return lock


def _remove(folder: Path, lock: "FileLock") -> None:
    """The folder, then the file that is locked; Windows removes that one only when it is released."""
    shutil.rmtree(folder, ignore_errors=True)
    with suppress(OSError):
        Path(lock.lock_file).unlink()
    lock.release()
    with suppress(OSError):
        Path(lock.lock_file).unlink()


def _base() -> Path:
    """The folder for all processes of this user; another one where somebody else has taken its name."""
    return next(_bases(), None) or Path(tempfile.mkdtemp(prefix=f"{_name()}-", dir=tempfile.gettempdir()))


def _bases() -> Iterator[Path]:
    place = Path(tempfile.gettempdir())
    for folder in (place / _name(), *sorted(place.glob(f"{_name()}-*"))):
        with suppress(FileExistsError):
            folder.mkdir(mode=0o700)
        if _is_own(folder):
            yield folder


def _name() -> str:
    return f"breastrig-{os.getuid()}" if hasattr(os, "getuid") else "breastrig"  # Windows has a place for each user


def _is_own(folder: Path) -> bool:
    """Whether it is a folder, no link to one, of this user, that nobody else can look into."""
    facts = folder.lstat()
    is_private = not hasattr(os, "getuid") or (facts.st_uid == os.getuid() and not facts.st_mode & 0o077)
    return stat.S_ISDIR(facts.st_mode) and is_private
