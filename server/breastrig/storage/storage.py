"""The data folder as one thing: its rows and its files.

`Storage(root)` is cheap and holds no lock; every process opens its own.  The server alone calls `prepare`,
which creates what is missing, and holds `exclusive` as long as it runs, because two servers on one data folder
would each carry out the same fits.
"""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path

from breastrig.core.errors import BadSettings
from breastrig.storage.database import Database
from breastrig.storage.folders import Folders


class Storage:
    """Rows (`database`) and files (`folders`) below `root`."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.folders = Folders(root)
        self.database = Database(self.folders.database)

    def prepare(self) -> None:
        """Creates folders and tables, or brings older tables up to date.

        Raises BadSettings when the place cannot be written, or was written by a newer version.
        """
        try:
            self.folders.create()
        except OSError as error:
            raise BadSettings(
                f"The data folder {self.root} cannot be created ({error.strerror}); choose another with --data."
            ) from error
        self.database.bring_up_to_date()
        self.folders.empty_rubbish()

    @contextmanager
    def exclusive(self) -> Iterator[None]:
        """Holds the data folder for this server.  Raises BadSettings when another server holds it."""
        handle = os.open(self.folders.lock, os.O_RDWR | os.O_CREAT, 0o600)
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
