"""Which kind of database and of files a location names.

What only large installations have installed is imported when it is needed.
"""

from breastrig.storage.data_folder import SQLITE_FILE
from breastrig.storage.database import Database
from breastrig.storage.disk_files import DiskFiles
from breastrig.storage.files import Files
from breastrig.storage.folders import Folders
from breastrig.storage.location import Location
from breastrig.storage.sqlite import SqliteDatabase


def open_database(location: Location) -> Database:
    """Raises BadSettings when what it needs is not installed."""
    if location.database is None:
        return SqliteDatabase(location.root / SQLITE_FILE)
    from breastrig.storage.postgres import PostgresDatabase

    return PostgresDatabase(location.database)


def open_files(location: Location, folders: Folders) -> Files:
    """Raises BadSettings when what it needs is not installed."""
    if location.files is None:
        return DiskFiles(folders)
    from breastrig.storage.store_files import StoreFiles

    return StoreFiles(location.files)
