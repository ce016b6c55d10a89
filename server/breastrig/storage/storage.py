"""Everything that is kept, as one thing: rows and files.

`Storage(location)` is cheap and holds no lock; every process opens its own.  The server alone calls `prepare`,
which creates what is missing, and holds `exclusive` as long as it runs, because two servers on one data folder
would each carry out the same fits.
"""

import fcntl
import os
from collections.abc import Collection, Iterator
from contextlib import AbstractContextManager, contextmanager
from datetime import UTC, datetime
from pathlib import Path

from breastrig.core.errors import BadSettings
from breastrig.storage.belonging import MARK, ROOT, check_belonging
from breastrig.storage.folders import Folders
from breastrig.storage.location import Location
from breastrig.storage.locks import FolderLocks, Locks
from breastrig.storage.open_location import open_database, open_files
from breastrig.storage.scratch import sweep_scratch


class Storage:
    """Rows (`database`) and files (`files`); `folders` are those of the data folder on this machine."""

    def __init__(self, location: Location | Path) -> None:
        self.location = location if isinstance(location, Location) else Location(location)
        self.root = self.location.root
        self.folders = Folders(self.root)
        self.database = open_database(self.location)
        self.files = open_files(self.location, self.folders)
        self._locks: Locks = self.database if isinstance(self.database, Locks) else FolderLocks(self.folders)

    def prepare(self) -> None:
        """Creates folders and tables, or brings older tables up to date.

        Raises BadSettings when the place cannot be written, was written by a newer version, or when the files are
        another database's.
        """
        try:
            self.folders.create()
        except OSError as error:
            raise BadSettings(
                f"The data folder {self.root} cannot be created ({error.strerror}); choose another with --data."
            ) from error
        self.database.bring_up_to_date()
        self.files.create()
        check_belonging(self.database, self.files, beside=self.location == Location(self.root))

    @contextmanager
    def exclusive(self) -> Iterator[None]:
        """Holds rows and files for this server.  Raises BadSettings when another server holds them."""
        handle = os.open(self.folders.lock, os.O_RDWR | os.O_CREAT, 0o600)
        try:
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise BadSettings(
                    f"Another BreastRig server uses the data folder {self.root}; stop it or choose another with --data."
                ) from error
            with self.database.exclusive():
                yield
        finally:
            os.close(handle)

    def has_files(self) -> bool:
        """Whether the place for files answers and is still the one that was prepared."""
        try:
            return self.files.find(ROOT, MARK) is not None
        except OSError:
            return False

    def make_fit(self, fit_id: str) -> None:
        """What a fit needs before its row is there: a folder here, to be locked by whoever carries it out."""
        self.folders.make(self.folders.fit(fit_id))

    def held(self, fit_id: str) -> AbstractContextManager[None]:
        """Marks the fit as being carried out, until the block ends or the process dies; waits for who has it.

        Raises FileNotFoundError when it was deleted, unless the database has to tell.
        """
        return self._locks.held(fit_id)

    def wait_until_free(self, fit_id: str, timeout_s: float) -> bool:
        """Whether nobody carries the fit out any more, waiting for that a little."""
        return self._locks.wait_until_free(fit_id, timeout_s)

    def remove(self, *places: str) -> None:
        """Removes the files of scans and fits (`files.scan_place`, `files.fit_place`); none there is no error."""
        self.files.remove(*places)
        self.folders.remove(*(self.root / place for place in places))
        sweep_scratch()

    def remove_strangers(self, known: Collection[str]) -> None:
        """Removes the files of all other places: what a killed upload or fit left behind."""
        self.files.remove_strangers(known)
        self.folders.remove_strangers(known)
        sweep_scratch()

    def close(self) -> None:
        self.database.close()


def iso_utc(moment: datetime) -> str:
    """ISO 8601 in UTC, to the millisecond; sorts as text in the order of time."""
    return moment.astimezone(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def utc_now() -> str:
    """The time as `iso_utc`."""
    return iso_utc(datetime.now(UTC))


def default_data_folder() -> Path:
    """The user's data folder by the XDG rules."""
    base = os.environ.get("XDG_DATA_HOME", "")
    return (Path(base) if base.startswith("/") else Path.home() / ".local" / "share") / "breastrig"
