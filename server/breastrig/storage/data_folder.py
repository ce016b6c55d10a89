"""The data folder belongs to BreastRig only if it carries a marker, which is looked for before anything is written.

    data/installation           the marker: the id of the installation, 22 characters, which its index names too

A server removes files from its data folder, so it must never take another program's folder for its own.  An empty or
missing folder becomes ours, and the marker is the first thing in it; any other folder without a marker is refused as
it is.
"""

import fcntl
import os
import re
import stat
from collections.abc import Callable
from enum import Enum
from pathlib import Path

from breastrig.core.errors import BadSettings
from breastrig.storage.files import MARK

PART = ".breastrig-installation.part"  # the marker while it is written
LOCK_FILE = "lock"
ID = re.compile(r"[A-Za-z0-9_-]{22}")
MARKER_BYTES = 22
OF_A_FILE_SYSTEM = {"lost+found"}  # in the root of a new disk


class Ownership(Enum):
    """The ownership of a folder that is named as data folder."""

    FOREIGN = "holds files and no marker"
    NEW = "empty or not there"
    OURS = "carries the marker"


def ownership_of(root: Path) -> Ownership:
    """Looks and changes nothing; BadSettings for what is no folder or cannot be read."""
    try:
        names = set(os.listdir(root))
    except FileNotFoundError as error:
        if root.is_symlink():
            raise BadSettings(
                f"The data folder {root} is a link that leads nowhere; mend the link or choose another with --data."
            ) from error
        return Ownership.NEW
    except NotADirectoryError as error:
        if root.exists():
            raise BadSettings(f"{root} is a file and no folder; choose a folder with --data.") from error
        raise _unusable(root, "created", error) from error
    except OSError as error:
        raise _unusable(root, "read", error) from error
    try:
        if installation_id(root) is not None:
            return Ownership.OURS
        if _holds_nothing(root, names - OF_A_FILE_SYSTEM):
            return Ownership.NEW
    except OSError as error:
        raise _unusable(root, "read", error) from error
    return Ownership.FOREIGN


def refuse_foreign(root: Path) -> Ownership:
    """The folder's ownership. Raises BadSettings for a folder of another program."""
    standing = ownership_of(root)
    if standing is Ownership.FOREIGN:
        raise BadSettings(
            f"{root} holds files but is no data folder of BreastRig, so it is left as it is; choose an empty or a new "
            "folder with --data."
        )
    return standing


def installation_id(root: Path) -> str | None:
    """The id in the marker; None without one that is ours."""
    marker = root / MARK
    if marker.is_symlink() or not marker.is_file() or marker.stat().st_size != MARKER_BYTES:
        return None
    text = marker.read_bytes().decode("ascii", "replace")
    return text if ID.fullmatch(text) else None


def claim(root: Path, new_id: Callable[[], str]) -> None:
    """Makes a new folder ours: writes the marker, whole or not at all, before anything else.

    Does nothing in a folder that is ours already.  Raises BadSettings.
    """
    if refuse_foreign(root) is not Ownership.NEW:
        return
    chosen = new_id()
    try:
        root.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise _unusable(root, "created", error) from error
    try:
        handle = os.open(root, os.O_RDONLY | os.O_DIRECTORY)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX)  # of two servers that start at once, one writes
            if refuse_foreign(root) is Ownership.NEW:
                write_marker(root, chosen)
        finally:
            os.close(handle)
    except OSError as error:
        raise _unusable(root, "written", error) from error


def write_marker(root: Path, installation: str) -> None:
    """Writes the marker, whole or not at all, also when the power fails. Raises OSError."""
    part = root / PART
    try:
        with part.open("wb") as file:
            file.write(installation.encode())
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, root / MARK)
    except OSError:
        part.unlink(missing_ok=True)
        raise
    handle = os.open(root, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _unusable(root: Path, verb: str, error: OSError) -> BadSettings:
    return BadSettings(f"The data folder {root} cannot be {verb} ({error.strerror}); choose another with --data.")


def _holds_nothing(root: Path, names: set[str]) -> bool:
    """Whether there is nothing, or only a marker whose writing was interrupted."""
    return not names - {PART} and (PART not in names or _can_be_a_part(root / PART))


def _can_be_a_part(part: Path) -> bool:
    """Also when it has gone: then another server has just made it the marker."""
    try:
        facts = part.lstat()
    except FileNotFoundError:
        return True
    return stat.S_ISREG(facts.st_mode) and facts.st_size <= MARKER_BYTES
