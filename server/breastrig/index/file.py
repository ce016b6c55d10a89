"""The file of an index: found by its name, opened, judged, exchanged for a new one.

Each new file has a name of its own, the greatest is in force.  SQLite removes and replays the log beside a file by its
name: a new file under the old name would lose its log to whoever still has the old one open, or be given that one's.
"""

import os
import re
import sqlite3
import time
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from filelock import lock_descriptor

from breastrig.cases.writing import FULL, sync_folder
from breastrig.index.schema import VERSION

NAME = re.compile(r"index-[0-9]{20}\.sqlite3")
NEW = ".new"  # behind the name while the file is made
LOCK = "index.lock"  # held by who makes a new file
BUSY_S = 30.0  # far above the longest transaction, so that only a hung disk shows
CHECK_S = 5.0  # a gigabyte of rows that the system has in memory
CHECK_EVERY = 10_000  # of SQLite's instructions, about a millisecond
DAMAGED = ("SQLITE_CORRUPT", "SQLITE_NOTADB")  # how the names of these errors begin
NOT_ITS_FAULT = ("SQLITE_INTERRUPT", "SQLITE_BUSY", "SQLITE_FULL", "SQLITE_IOERR", "SQLITE_CANTOPEN", "SQLITE_READONLY")
PRAGMAS = ("journal_mode = WAL", "synchronous = NORMAL", "secure_delete = ON")

Identity = tuple[str, int, int]  # name, device, inode


def current(folder: Path) -> Path | None:
    """The file in force; None where there is none."""
    names = [name for name in os.listdir(folder) if NAME.fullmatch(name)]
    return folder / max(names) if names else None


def identity(folder: Path) -> Identity | None:
    """The identity of the file in force: another one when it was exchanged."""
    file = current(folder)
    if file is None:
        return None
    try:
        facts = file.stat()
    except FileNotFoundError:
        return None
    return file.name, facts.st_dev, facts.st_ino


@contextmanager
def made(folder: Path) -> Iterator[tuple[sqlite3.Connection, Path | None]]:
    """A new file, in force at the end of the block, when older ones are removed; on an error it is removed.

    With the file that has been in force.  One program at a time makes one.
    """
    lock = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT | getattr(os, "O_CLOEXEC", 0), 0o600)
    try:
        lock_descriptor(lock)
        before = current(folder)
        number = max(time.time_ns(), 0 if before is None else int(before.name[6:26]) + 1)
        file = folder / f"index-{number:020}.sqlite3"
        new = file.with_name(file.name + NEW)
        _remove(folder.glob(f"index-*{NEW}*"))  # of killed programs
        new.touch(mode=0o600)  # SQLite would let others read it
        try:
            with closing(connected(new)) as rows:
                yield rows, before
                rows.execute(f"PRAGMA user_version = {VERSION}")
                rows.execute("PRAGMA journal_mode = DELETE")  # all is in the one file, which is renamed
            os.replace(new, file)
        except BaseException:
            _remove([*folder.glob(f"{new.name}*")])
            raise
        sync_folder(folder)
        _remove(each for each in folder.iterdir() if NAME.match(each.name) and not each.name.startswith(file.name))
    finally:
        os.close(lock)


def _remove(files: Iterable[Path]) -> None:
    for each in list(files):
        each.unlink(missing_ok=True)


def opened(file: Path) -> sqlite3.Connection:
    """A connection with explicit transactions that takes the file as it is. Raises sqlite3.Error."""
    address = f"{file.absolute().as_uri()}?mode=rw"
    return sqlite3.connect(address, uri=True, timeout=BUSY_S, isolation_level=None, check_same_thread=False)


def connected(file: Path) -> sqlite3.Connection:
    """A connection with explicit transactions. Raises sqlite3.Error."""
    rows = opened(file)
    try:
        for pragma in PRAGMAS:
            rows.execute(f"PRAGMA {pragma}")
    except sqlite3.Error:
        rows.close()
        raise
    return rows


@contextmanager
def transaction(rows: sqlite3.Connection) -> Iterator[None]:
    """Holds the write lock from its start; undoes all on an error."""
    rows.execute("BEGIN IMMEDIATE")
    try:
        yield
    except BaseException:
        rows.rollback()
        raise
    rows.commit()


def fault_of(file: Path | None, installation: str) -> str | None:
    """The reason why the file cannot be used, as far as some seconds show; None where there is none."""
    if file is None or not file.is_file() or not file.stat().st_size:
        return "is not there"
    deadline = time.monotonic() + CHECK_S
    try:
        with closing(connected(file)) as rows:  # one of its own: the others remember pages that they have read
            if rows.execute("PRAGMA user_version").fetchone()[0] != VERSION:
                return "is of another version"
            if installation_of(rows) != installation:
                return "is of another data folder"
            rows.set_progress_handler(lambda: time.monotonic() > deadline, CHECK_EVERY)
            sound: bool = rows.execute("PRAGMA quick_check(1)").fetchone() == ("ok",)
            return None if sound else "is damaged"
    except sqlite3.DatabaseError as error:
        return None if error_name(error).startswith(NOT_ITS_FAULT) else "is damaged"


def installation_of(rows: sqlite3.Connection) -> str | None:
    """The id of the data folder that an index belongs to."""
    named = rows.execute("SELECT value FROM meta WHERE key = 'installation'").fetchone()
    return None if named is None else str(named[0])


def is_damage(error: Exception) -> bool:
    """Whether an error was caused by a damaged file, or by one that has not our tables, such as an empty one."""
    return error_name(error).startswith(DAMAGED) or str(error).startswith(("no such table", "no such column"))


def is_full(error: Exception) -> bool:
    """Whether an error was caused by a full disk, as far as SQLite reports it."""
    full = isinstance(error, OSError) and error.errno in FULL
    return full or error_name(error).startswith(("SQLITE_FULL", "SQLITE_IOERR", "SQLITE_CANTOPEN"))


def error_name(error: Exception) -> str:
    """SQLite's name for an error; empty for others."""
    return str(getattr(error, "sqlite_errorname", ""))
