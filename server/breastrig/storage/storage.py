"""Everything that is kept, as one thing: rows and files.

`Storage(root)` is cheap and holds no lock; every process opens its own.  The server alone calls `prepare`,
which creates what is missing, and holds `exclusive` as long as it runs, because two servers on one data folder
would each run the same fits.  Both look first whether the data folder is BreastRig's (see `data_folder`).
"""

import errno
import fcntl
import logging
import os
import sqlite3
from collections.abc import Callable, Collection, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TypeVar

from sqlalchemy.exc import DBAPIError

from breastrig.core import wall_clock
from breastrig.core.errors import BadSettings
from breastrig.core.scratch import sweep_scratch
from breastrig.storage.data_folder import SQLITE_FILE, claim
from breastrig.storage.database import Database
from breastrig.storage.files import MARK, MODELS, ROOT, fit_place
from breastrig.storage.folders import Folders, new_id
from breastrig.storage.installation_id import check_belonging
from breastrig.storage.reserve import Reserve

log = logging.getLogger(__name__)

PRIORS = "priors.json"  # beside the models
CHECK_S = 5.0  # a gigabyte of rows that the system has in memory
FULL = (errno.ENOSPC, errno.EDQUOT)
Result = TypeVar("Result")


@dataclass(frozen=True)
class Unremoved:
    """Files that could not be removed."""

    place: str
    where: str  # for people
    reason: str


class Storage:
    """Rows (`database`) and files (`files`) of one data folder."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.files = Folders(root)
        self.database = Database(root / SQLITE_FILE)
        self.reserve = Reserve(self.files.reserve)
        self._forget_again = False
        self.was_damaged = False  # when the whole database was looked at last

    def prepare(self) -> None:
        """Creates folders and tables, or brings older tables up to date.

        Raises BadSettings when the data folder belongs to another program or database, cannot be written, is damaged,
        or was written by a newer version.
        """
        self._claim()
        try:
            self.using_reserve(self.files.create)
            self.using_reserve(self.database.bring_up_to_date)
            self._forget_priors()
            self.using_reserve(lambda: check_belonging(self.database, self.root, self.files))
        except OSError as error:
            raise self._unusable(error.strerror) from error
        except (DBAPIError, sqlite3.Error) as error:
            raise self._unusable(str(getattr(error, "orig", error))) from error

    def _forget_priors(self) -> None:
        """Empties the sums over patients that a service could learn once: deleted patients may be among them."""
        found = self.files.find(MODELS, PRIORS)
        if found is not None and found.size:
            self.files.write(MODELS, PRIORS, b"")

    @contextmanager
    def exclusive(self) -> Iterator[None]:
        """Holds rows and files for this server.

        Raises BadSettings when another server holds them, and when the data folder is another program's.
        """
        self._claim()
        try:
            handle = self.using_reserve(lambda: os.open(self.files.lock, os.O_RDWR | os.O_CREAT, 0o600))
        except OSError as error:
            raise self._unusable(error.strerror) from error
        try:
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise BadSettings(
                    f"Another BreastRig server uses the data folder {self.root}; stop it or choose another with --data."
                ) from error
            yield
        finally:
            os.close(handle)

    def _claim(self) -> None:
        """Makes a new data folder ours; nothing comes before the marker."""
        claim(self.root, new_id)

    def _unusable(self, reason: str | None) -> BadSettings:
        return BadSettings(
            f"The data folder {self.root} cannot be written ({reason or 'for no known reason'}); make room, mend its "
            "permissions, or choose another with --data."
        )

    def using_reserve(self, write: Callable[[], Result]) -> Result:
        """Writes what must not fail for a full disk, giving up the reserve part by part; it may be called repeatedly.

        Raises what `write` raises once there is no reserve left.
        """
        while True:
            try:
                return write()
            except (OSError, DBAPIError, sqlite3.Error) as error:
                if not self.is_disk_full(error) or not self.reserve.release():
                    raise

    def is_disk_full(self, error: Exception) -> bool:
        """Whether it was met because the disk of the data folder is full."""
        return (isinstance(error, OSError) and error.errno in FULL) or self.database.is_disk_full(error)

    def refill_reserve(self) -> None:
        """Sets space aside for the deletion that comes when the disk is full."""
        self.reserve.refill()

    def forget_deleted(self) -> None:
        """Gives up what deleted rows still take, now or at the next call of `forget_pending`."""
        self._forget_again = not self.using_reserve(self.database.forget_deleted)

    def forget_pending(self) -> None:
        if self._forget_again:
            self.forget_deleted()

    def check_integrity(self) -> None:
        """At the whole database, or as much of it as some seconds suffice for."""
        self.was_damaged = not self.database.is_sound(CHECK_S)
        if self.was_damaged:
            log.error("the database is damaged; put a copy of the data folder in its place")

    def has_files(self) -> bool:
        """Whether the data folder answers and is still the one that was prepared."""
        try:
            return self.files.find(ROOT, MARK) is not None
        except OSError:
            return False

    def make_fit(self, fit_id: str) -> None:
        """What a fit needs before its row is there: a folder, to be locked by whoever carries it out."""
        self.files.make(fit_place(fit_id))

    def held(self, fit_id: str) -> AbstractContextManager[None]:
        """Marks the fit as being executed, until the block ends or the process dies; waits for who has it.

        Raises FileNotFoundError when it was deleted.
        """
        return self.files.held(fit_id)

    def wait_until_free(self, fit_id: str, timeout_s: float) -> bool:
        """Whether nobody carries the fit out any more, waiting for that a little."""
        return self.files.wait_until_free(fit_id, timeout_s)

    def remove(self, *places: str) -> list[Unremoved]:
        """Removes the files of scans and fits (`files.scan_place`, `files.fit_place`); none there is no error.

        What could not be removed.
        """
        left = []
        for place in places:
            try:
                self.files.remove(place)
            except OSError as error:
                left.append(Unremoved(place, self.files.left_of(place), error.strerror or type(error).__name__))
        with suppress(OSError):
            sweep_scratch()
        return left

    def count_unknown(self, known: Collection[str]) -> int:
        """How many files and folders lie where scans and fits are kept, and belong to none of these places."""
        return self.files.count_unknown(known)

    def close(self) -> None:
        self.database.close()


def iso_utc(moment: datetime) -> str:
    """ISO 8601 in UTC, to the millisecond; sorts as text in the order of time."""
    return moment.astimezone(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def utc_now() -> str:
    """The time as `iso_utc`."""
    return iso_utc(wall_clock.now())


def default_data_folder() -> Path:
    """The user's data folder by the XDG rules."""
    base = os.environ.get("XDG_DATA_HOME", "")
    return (Path(base) if base.startswith("/") else Path.home() / ".local" / "share") / "breastrig"
