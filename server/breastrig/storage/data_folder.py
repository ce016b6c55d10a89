"""The data folder belongs to BreastRig only if it carries a marker, which is looked for before anything is written.

    data/installation           the marker: the id of the installation, 22 characters, which its database holds too

A server removes files from its data folder, so it must never take another program's folder for its own.  An empty or
missing folder becomes ours, and the marker is the first thing in it; any other folder without a marker is refused as
it is.  Data folders of versions that wrote no marker are known by the tables in their database.
"""

import fcntl
import os
import re
import shutil
import sqlite3
import stat
from collections.abc import Callable
from contextlib import closing
from enum import Enum
from pathlib import Path

from breastrig.core.errors import BadSettings
from breastrig.core.scratch import scratch_folder
from breastrig.storage.files import MARK

PART = ".breastrig-installation.part"  # the marker while it is written
SQLITE_FILE = "breastrig.sqlite3"
LOCK_FILE = "lock"
RESERVE_FILE = "reserve"
PLACES = ("scans", "fits", "shares")
RUBBISH = "rubbish"
ID = re.compile(r"[A-Za-z0-9_-]{22}")
MARKER_BYTES = 22
OUR_TABLES = {"scans", "landmarks", "fits", "events"}  # in every version
OF_A_FILE_SYSTEM = {"lost+found"}  # in the root of a new disk


class Ownership(Enum):
    """Of a folder that is named as data folder."""

    FOREIGN = "holds files and no marker"
    NEW = "empty or not there"
    OURS = "carries the marker"
    OLDER = "made by a version that wrote no marker"


def ownership_of(root: Path, sqlite: bool) -> Ownership:
    """Looks and changes nothing; `sqlite`: the rows are expected in the folder itself.

    Raises BadSettings for what is no folder or cannot be read.
    """
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
        if sqlite and _lacks_marker(root / MARK) and _has_our_tables(root / SQLITE_FILE):
            return Ownership.OLDER
    except OSError as error:
        raise _unusable(root, "read", error) from error
    return Ownership.FOREIGN


def refuse_foreign(root: Path, sqlite: bool) -> Ownership:
    """The same.  Raises BadSettings for a folder of another program too."""
    standing = ownership_of(root, sqlite)
    if standing is Ownership.FOREIGN:
        raise BadSettings(
            f"{root} holds files but is no data folder of BreastRig, so it is left as it is; choose an empty or a new "
            "folder with --data."
        )
    return standing


def installation_id(root: Path) -> str | None:
    """What the marker says; None without one that is ours."""
    marker = root / MARK
    if marker.is_symlink() or not marker.is_file() or marker.stat().st_size != MARKER_BYTES:
        return None
    text = marker.read_bytes().decode("ascii", "replace")
    return text if ID.fullmatch(text) else None


def claim(root: Path, new_id: Callable[[], str], sqlite: bool) -> None:
    """Makes a new folder ours: writes the marker, whole or not at all, before anything else.

    Does nothing in a folder that is ours already.  Raises BadSettings.
    """
    if refuse_foreign(root, sqlite) is not Ownership.NEW:
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
            if refuse_foreign(root, sqlite) is Ownership.NEW:
                write_marker(root, chosen)
        finally:
            os.close(handle)
    except OSError as error:
        raise _unusable(root, "written", error) from error


def write_marker(root: Path, installation: str) -> None:
    """Whole or not at all, also when the power fails.  Raises OSError."""
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
    """Whether nobody can miss what is in the folder.

    That is nothing, a marker whose writing was interrupted, or the empty folders and the lock of a server that keeps
    rows and files elsewhere and is of a version that wrote no marker.
    """
    if PART in names and not _can_be_a_part(root / PART):
        return False
    rest = names - {PART}
    if not rest:
        return True
    lock, rubbish = root / LOCK_FILE, root / RUBBISH
    places = rest - {LOCK_FILE, RUBBISH}
    if (
        rest - places != {LOCK_FILE, RUBBISH}
        or places != {"scans", "fits"}
        or not lock.is_file()
        or lock.stat().st_size
    ):
        return False
    folders = [rubbish, *(root / name for name in places)]
    if any(folder.is_symlink() or not folder.is_dir() for folder in folders):
        return False
    inside = [Path(entry) for name in places for entry in os.scandir(root / name)]
    return all(_is_empty_folder(folder) for folder in (rubbish, *inside))


def _can_be_a_part(part: Path) -> bool:
    """Also when it has gone: then another server has just made it the marker."""
    try:
        facts = part.lstat()
    except FileNotFoundError:
        return True
    return stat.S_ISREG(facts.st_mode) and facts.st_size <= MARKER_BYTES


def _lacks_marker(marker: Path) -> bool:
    """Whether there is no file of that name, or one that lost its content when the power failed."""
    return not os.path.lexists(marker) or (marker.is_file() and marker.stat().st_size == 0)


def _is_empty_folder(path: Path) -> bool:
    return path.is_dir() and not path.is_symlink() and not os.listdir(path)


def _has_our_tables(file: Path) -> bool:
    """Looks into a database that nobody has open, and leaves no file beside it.

    Tables that are only in the log of a server that was killed early are looked for in a copy.
    """
    if file.is_symlink() or not file.is_file():
        return False
    if _tables(file) >= OUR_TABLES:
        return True
    log = file.with_name(f"{file.name}-wal")
    if not log.is_file():
        return False
    with scratch_folder() as folder:
        for one in (file, log):
            shutil.copyfile(one, folder / one.name)
        return _tables(folder / file.name, immutable=False) >= OUR_TABLES


def _tables(file: Path, *, immutable: bool = True) -> set[str]:
    """Their names; none when it is no SQLite database."""
    try:
        with closing(sqlite3.connect(f"{file.absolute().as_uri()}?immutable={int(immutable)}", uri=True)) as rows:
            return {row[0] for row in rows.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    except sqlite3.Error:
        return set()
