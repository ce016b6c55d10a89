"""Files that only their owner may read, reading that never waits, and paths for sentences.

Results show patients: files are for their owner only (0600), so are folders that are made for them (0700), whatever
the umask says.  A folder that was there keeps its mode.
"""

import errno
import os
import shutil
import stat
import tempfile
from contextlib import suppress
from fcntl import LOCK_EX, LOCK_NB, flock
from pathlib import Path

PREFIX = ".breastrig-part-"  # of what is written under another name until it is complete


def private_folder(folder: Path) -> list[Path]:
    """Makes the folder and those above it that are missing, for their owner only; those made, outermost first."""
    folder = folder.absolute()
    missing = [folder, *folder.parents]
    missing = missing[: next((k for k, each in enumerate(missing) if each.is_dir()), len(missing))]
    for each in reversed(missing):
        each.mkdir(mode=0o700)
        each.chmod(0o700)
    return missing[::-1]


def write_private(file: Path, content: bytes) -> None:
    """Writes a file for its owner only, whole or not at all, in the place of an older one."""
    handle, name = tempfile.mkstemp(prefix=PREFIX, dir=file.parent)  # 0600
    try:
        with os.fdopen(handle, "wb") as partial:
            _locked(handle)
            partial.write(content)
            partial.flush()
            os.replace(name, file)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def is_ordinary(file: Path) -> bool:
    """Whether it is a file that can be read to its end: no folder, pipe or device, no name that cannot be."""
    try:
        return stat.S_ISREG(file.stat().st_mode)
    except (OSError, ValueError):
        return False


def read_ordinary(file: Path, limit: int) -> bytes:
    """The file's bytes, at most one more than the limit; OSError at once for a pipe, a device or a folder."""
    handle = os.open(file, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    with os.fdopen(handle, "rb") as stream:
        if not stat.S_ISREG(os.fstat(handle).st_mode):
            raise OSError(errno.EINVAL, "it is no ordinary file", str(file))
        return stream.read(limit + 1)


def shown(path: Path | str) -> str:
    """The path for a sentence: as it was given, shortened in the middle if it is very long."""
    text = str(path)
    return text if len(text) <= 200 else f"{text[:90]} ... {text[-90:]}"


def private_part(folder: Path) -> tuple[Path, int]:
    """A new private folder inside, and a handle that holds a lock on it: who finds one unlocked may remove it."""
    while True:
        staging = Path(tempfile.mkdtemp(prefix=PREFIX, dir=folder))  # 0700
        with suppress(FileNotFoundError):  # removed by another run before it was locked
            handle = os.open(staging, os.O_RDONLY | os.O_DIRECTORY)
            if _locked(handle) and staging.is_dir():
                return staging, handle
            os.close(handle)


def remove_leftovers(folder: Path) -> None:
    """What a killed run left half-done; a run that is at work holds a lock on its own."""
    for leftover in folder.glob(PREFIX + "*"):
        with suppress(OSError):
            handle = os.open(leftover, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
            try:
                flock(handle, LOCK_EX | LOCK_NB)
                if leftover.is_dir():
                    shutil.rmtree(leftover, ignore_errors=True)
                elif leftover.is_file():
                    leftover.unlink()
            finally:
                os.close(handle)


def _locked(handle: int) -> bool:
    """Locks for as long as the handle is open; True also where the file system knows no locks."""
    try:
        flock(handle, LOCK_EX | LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True
