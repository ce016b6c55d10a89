"""The places of the files of scans, fits and links: in their case, or, while they are made, in `incoming`.

    data/installation           says that the folder is BreastRig's (see `data_folder`)
    data/lock                   held by the server
    data/cases/ID/              one patient each (see cases/layout.py)
    data/incoming/              what is being made
    data/rubbish/               what is on its way out, or being moved
    data/models/SHA256.zip      the models that fits were made with
    data/index-*.sqlite3        finds all that (see index/)

Original file names are never stored.
"""

import errno
import os
import time
from pathlib import Path

from filelock import lock_descriptor

from breastrig.cases import layout
from breastrig.cases.layout import new_id as new_id
from breastrig.index import questions
from breastrig.index.index import Index
from breastrig.storage.data_folder import LOCK_FILE
from breastrig.storage.files import MODELS, OpenedFile, fit_place, scan_place


class Folders:
    """The folders of one data folder, which only their owner can read.  May be used from any thread."""

    def __init__(self, root: Path, index: Index) -> None:
        self.root = root
        self.lock = root / LOCK_FILE
        self._index = index

    def scan(self, scan_id: str) -> Path:
        return self.folder(scan_place(scan_id))

    def fit(self, fit_id: str) -> Path:
        return self.folder(fit_place(fit_id))

    def create(self) -> None:
        for name in (layout.CASES, layout.INCOMING, layout.RUBBISH, MODELS):
            (self.root / name).mkdir(mode=0o700, parents=True, exist_ok=True)

    def make(self, place: str) -> None:
        """Before anything is put there: it is nobody's until it is put into a case."""
        self.made(place).mkdir(mode=0o700)

    def made(self, place: str) -> Path:
        """The folder of a place while it is made."""
        return self.root / layout.INCOMING / place.replace("/", ".")

    def folder(self, place: str) -> Path:
        """The folder of a place in a case, else of one that is being made, or was deleted."""
        return self._kept(place) or (self.root / place if place in ("", MODELS) else self.made(place))

    def _kept(self, place: str) -> Path | None:
        kind, _, name = place.partition("/")
        cases = self.root / layout.CASES
        if kind == "scans":
            case = self._index.asked(questions.case_of_scan, name)
            return None if case is None else cases / case / layout.scan_part(name)
        if kind == "fits":
            found = self._index.asked(questions.case_of_fit, name)
            return None if found is None else cases / found[0] / layout.fit_part(found[1], name)
        if kind == "shares":
            link, _, number = name.partition(".")
            where = self._index.asked(questions.fit_of_link, link)
            if where is None:
                return None
            return cases / where[0] / layout.link_part(where[1], where[2], link) / f"{layout.SHOWN}{number}"
        return None

    def find(self, place: str, name: str) -> OpenedFile | None:
        """The file, if it is there."""
        path = self.folder(place) / name
        try:
            facts = path.stat()
        except (FileNotFoundError, NotADirectoryError):
            return None
        return OpenedFile(path, facts.st_size, f"{facts.st_mtime_ns:x}-{facts.st_size:x}", lambda: path.open("rb"))

    def write(self, place: str, name: str, content: bytes) -> None:
        """Keeps one file, whole or not at all.  Raises OSError."""
        path = self.folder(place) / name
        partial = path.with_name(f"{name}.part")
        try:
            partial.write_bytes(content)
            os.replace(partial, path)
        except OSError:
            partial.unlink(missing_ok=True)
            raise

    def wait_until_free(self, fit_id: str, timeout_s: float) -> bool:
        """Whether nobody is at work at the fit any more, waiting for that a little."""
        try:
            handle = os.open(self.fit(fit_id) / layout.CLAIM, os.O_RDWR)
        except (FileNotFoundError, NotADirectoryError):
            return True
        except OSError as error:
            if error.errno == errno.EROFS:
                return True  # where nothing can be written, nobody is at work
            raise
        deadline = time.monotonic() + timeout_s
        try:
            while not lock_descriptor(handle, blocking=False):
                if time.monotonic() > deadline:
                    return False
                time.sleep(0.01)
            return True
        finally:
            os.close(handle)
