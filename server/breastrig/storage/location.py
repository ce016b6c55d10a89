"""Where rows and files are: all that a worker on another machine needs to know, and how they are opened there.

What only large installations have installed is imported when it is needed.
"""

from dataclasses import dataclass, field
from pathlib import Path

from breastrig.storage.data_folder import SQLITE_FILE
from breastrig.storage.database import Database
from breastrig.storage.files import Files, Locks
from breastrig.storage.folders import Folders
from breastrig.storage.sqlite import SqliteDatabase


@dataclass(frozen=True)
class Location:
    """Everything below `root`, unless an address says otherwise."""

    root: Path  # on this machine
    database: str | None = field(default=None, repr=False)  # postgresql://...; it may hold a password
    files: str | None = None  # s3://bucket/prefix or another URL that fsspec knows


def open_database(location: Location, folders: Folders) -> tuple[Database, Locks]:
    """And the locks of its fits.  Raises BadSettings when what it needs is not installed."""
    if location.database is None:
        return SqliteDatabase(location.root / SQLITE_FILE), folders
    from breastrig.storage.postgres import PostgresDatabase

    database = PostgresDatabase(location.database)
    return database, database


def open_files(location: Location, folders: Folders) -> Files:
    """Raises BadSettings when what it needs is not installed."""
    if location.files is None:
        return folders
    from breastrig.storage.store_files import StoreFiles

    return StoreFiles(location.files)
