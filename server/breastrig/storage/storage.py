"""Everything that is kept, as one thing: cases, and the index that finds them.

`Storage(root)` is cheap and holds no lock; every process opens its own.  The server alone calls `prepare`,
which creates what is missing, and holds `exclusive` as long as it runs, because two servers on one data folder
would each run the same fits.  Both look first whether the data folder is BreastRig's (see `data_folder`).
"""

import fcntl
import logging
import os
import sqlite3
import tempfile
import threading
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from breastrig.cases import layout
from breastrig.cases.case_folder import NO_SCAN, CaseFolder, MadeScan, remove_tree
from breastrig.cases.fits import NO_FIT
from breastrig.cases.writing import NONE_HERE
from breastrig.core import wall_clock
from breastrig.core.errors import BadSettings, NotFound
from breastrig.core.scratch import sweep_scratch
from breastrig.index import questions
from breastrig.index.index import Index
from breastrig.storage.data_folder import claim
from breastrig.storage.files import MARK, MODELS, ROOT
from breastrig.storage.folders import Folders, new_id

log = logging.getLogger(__name__)

PRIORS = "priors.json"  # beside the models
ROOM_BYTES = 65_536  # of one fit's log, or a plan with its version before


@dataclass(frozen=True)
class Unremoved:
    """Files that could not be removed."""

    place: str
    where: str  # for people
    reason: str


class Storage:
    """Cases and their `index`; `files` locates files."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.index = Index(root)
        self.files = Folders(root, self.index)
        self.asking = threading.Lock()  # of fits
        self.groups_in_reach: Callable[[], Collection[str] | None] = lambda: None  # of whoever asks; None: all patients
        self._forget_again = False

    def new_code(self) -> str:
        """A random code that no patient here has."""
        return self.index.asked(questions.new_code)

    def prepare(self) -> None:
        """Creates folders, and the index where there is none, or one that cannot be used.

        Raises BadSettings when the data folder belongs to another program, or cannot be written.
        """
        self.create()
        try:
            self._forget_priors()
            self.index.prepare()
        except OSError as error:
            raise self._unusable(error.strerror) from error
        except sqlite3.Error as error:
            raise self._unusable(str(error)) from error

    def create(self) -> None:
        """Creates missing folders. Raises as `prepare`."""
        self._claim()
        try:
            self.files.create()
        except OSError as error:
            raise self._unusable(error.strerror) from error

    def _forget_priors(self) -> None:
        """Empties the sums over patients that a service could learn once: deleted patients may be among them."""
        found = self.files.find(MODELS, PRIORS)
        if found is not None and found.size:
            self.files.write(MODELS, PRIORS, b"")

    @contextmanager
    def exclusive(self) -> Iterator[None]:
        """Holds the data folder for this server.

        Raises BadSettings when another server holds it, and when it is another program's.
        """
        self._claim()
        try:
            handle = os.open(self.files.lock, os.O_RDWR | os.O_CREAT, 0o600)
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

    def case(self, case_id: str) -> CaseFolder:
        """The case of that id. Raises NotFound, also for one that is not in the reach of whoever asks."""
        if not layout.ID.fullmatch(case_id):
            raise NotFound(NONE_HERE)
        try:
            case = CaseFolder(self.root / layout.CASES / case_id)
        except NotFound as error:
            raise NotFound(NONE_HERE) from error
        groups = self.groups_in_reach()
        if groups is not None and case.document().group not in groups:
            raise NotFound(NONE_HERE)
        return case

    def new_case(self, first: MadeScan, group: str | None = None) -> CaseFolder:
        """A case with its first scan, under a new random code, that the group owns.  Raises OSError."""
        return CaseFolder.of_scan(self.new_place(), self.new_code(), first, group)

    def new_place(self) -> Path:
        """The folder of a case that is to be made."""
        return self.root / layout.CASES / new_id()

    def case_of_scan(self, scan_id: str) -> CaseFolder:
        """The scan's case. Raises NotFound."""
        found = self.index.asked(questions.case_of_scan, scan_id)
        try:
            if found is not None:
                return self.case(found)
        except NotFound:
            pass
        raise NotFound(NO_SCAN)

    def case_of_fit(self, fit_id: str) -> tuple[CaseFolder, str]:
        """The fit's case, and its scan's id. Raises NotFound."""
        found = self.index.asked(questions.case_of_fit, fit_id)
        try:
            if found is not None:
                return self.case(found[0]), found[1]
        except NotFound:
            pass
        raise NotFound(NO_FIT)

    def forget_deleted(self) -> None:
        """Gives up what deleted rows still take, now or at the next call of `forget_pending`."""
        self._forget_again = not self.index.forget_deleted()

    def forget_pending(self) -> None:
        if self._forget_again:
            self.forget_deleted()

    def has_room(self) -> bool:
        """Whether something can be written into the data folder."""
        try:
            with tempfile.TemporaryFile(dir=self.root / layout.INCOMING, buffering=0) as file:  # it has no name
                file.write(bytes(ROOM_BYTES))
                return True
        except OSError:
            return False

    def has_files(self) -> bool:
        """Whether the data folder answers and is still the one that was prepared."""
        try:
            return self.files.find(ROOT, MARK) is not None
        except OSError:
            return False

    def discard(self, *places: str) -> None:
        """Removes files that were made and are not kept after all; the rest goes at the next start."""
        for place in places:
            with suppress(OSError):
                remove_tree(self.files.made(place))
        with suppress(OSError):
            sweep_scratch()

    def close(self) -> None:
        self.index.close()


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
