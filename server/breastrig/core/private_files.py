"""Files that only their owner may read, reading that never waits, and paths for sentences.

Results show patients: files are for their owner only (0600), so are folders that are made for them (0700), whatever
the umask says.  A folder that was there keeps its mode.
"""

import errno
import os
import stat
import tempfile
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from breastrig.core.errors import BadInput

PREFIX = ".breastrig-file-"  # of what is written under another name until it is complete
PARTIAL_S = 3600.0
WITHOUT_WAITING = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)


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
            partial.write(content)
        os.replace(name, file)  # closed, as Windows demands
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def write_files(files: Mapping[str, bytes], folder: Path) -> None:
    """Writes them in that order, each as `write_private`; BadInput when the folder cannot be made or written."""
    try:
        private_folder(folder)
        for name, content in files.items():
            write_private(folder / name, content)
    except OSError as error:
        raise BadInput(
            f"{shown(folder)} cannot be written ({error.strerror}); free space, or choose another."
        ) from error


def is_ordinary(file: Path) -> bool:
    """Whether it is a file that can be read to its end: no folder, pipe or device, no name that cannot be."""
    try:
        return stat.S_ISREG(file.stat().st_mode)
    except (OSError, ValueError):
        return False


def is_folder(path: Path) -> bool:
    """Whether it is a folder; a name that cannot be is none."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def read_ordinary(file: Path, limit: int) -> bytes:
    """The file's bytes, at most one more than the limit; OSError at once for a pipe, a device or a folder."""
    handle = os.open(file, os.O_RDONLY | WITHOUT_WAITING)
    with os.fdopen(handle, "rb") as stream:
        if not stat.S_ISREG(os.fstat(handle).st_mode):
            raise OSError(errno.EINVAL, "it is no ordinary file", str(file))
        return stream.read(limit + 1)


def shown(path: Path | str) -> str:
    """The path for a sentence: as it was given, shortened in the middle if it is very long."""
    text = str(path)
    return text if len(text) <= 200 else f"{text[:90]} ... {text[-90:]}"


def remove_partial_files(folder: Path) -> None:
    """Removes files that a killed run left half written: writing one takes less than an hour."""
    for partial in folder.glob(PREFIX + "*"):
        with suppress(OSError):
            if stat.S_ISREG(partial.lstat().st_mode) and time.time() - partial.lstat().st_mtime > PARTIAL_S:
                partial.unlink()
