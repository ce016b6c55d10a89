"""The files of scans, fits and share links: one folder each, named by an unguessable id, below the data folder.

    data/installation           says that the folder is BreastRig's (see `data_folder`)
    data/breastrig.sqlite3      rows
    data/scans/ID/              scan.stored (what was read of the upload), mesh.glb (for display), thumbnail.png
    data/fits/ID/               result.json, scan.ply (cleaned), fitted.ply, fitted.glb, drawing.json,
                                distances.bin, uncertainty.bin, body.bin, fit.log.jsonl
    data/shares/ID/             what one share link shows (see workflow/share_snapshot.py)
    data/models/SHA256.zip      the models that fits were made with
    data/rubbish/KIND.ID        on its way out: a folder is first moved here, so that no path into it works any more
    data/reserve                space that a full disk has left for deleting (see `reserve`)
    data/lock                   held by the server

Original file names are never stored.
"""

import fcntl
import os
import secrets
import shutil
import threading
import time
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from breastrig.storage.data_folder import LOCK_FILE, PLACES, RESERVE_FILE, RUBBISH
from breastrig.storage.files import MODELS, OpenedFile, fit_place, scan_place


def new_id() -> str:
    """128 random bits as 22 URL-safe characters."""
    return secrets.token_urlsafe(16)


class Folders:
    """The folders of one data folder, which only their owner can read.  May be used from any thread."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.lock = root / LOCK_FILE
        self.reserve = root / RESERVE_FILE
        self._rubbish = root / RUBBISH
        self._removing = threading.Lock()  # who finds a folder half removed would not know whether it will be gone

    def scan(self, scan_id: str) -> Path:
        return self.root / scan_place(scan_id)

    def fit(self, fit_id: str) -> Path:
        return self.root / fit_place(fit_id)

    def create(self) -> None:
        for folder in (self.root, *(self.root / name for name in PLACES), self._rubbish, self.root / MODELS):
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)

    def make(self, place: str) -> None:
        """Before anything is put there."""
        (self.root / place).mkdir(mode=0o700)

    def folder(self, place: str) -> Path:
        return self.root / place

    def find(self, place: str, name: str) -> OpenedFile | None:
        """The file, if it is there."""
        path = self.root / place / name
        try:
            facts = path.stat()
        except FileNotFoundError:
            return None
        return OpenedFile(path, facts.st_size, f"{facts.st_mtime_ns:x}-{facts.st_size:x}", lambda: path.open("rb"))

    def write(self, place: str, name: str, content: bytes) -> None:
        """Keeps one file, whole or not at all.  Raises OSError."""
        path = self.root / place / name
        partial = path.with_name(f"{name}.part")
        try:
            partial.write_bytes(content)
            os.replace(partial, path)
        except OSError:
            partial.unlink(missing_ok=True)
            raise

    @contextmanager
    def held(self, fit_id: str) -> Iterator[None]:
        """Marks the fit as being executed, until the block ends or the process dies; waits for who has it.

        By a lock of its folder.  Raises FileNotFoundError when the fit was deleted.
        """
        handle = os.open(self.fit(fit_id), os.O_RDONLY | os.O_DIRECTORY)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX)
            yield
        finally:
            os.close(handle)

    def wait_until_free(self, fit_id: str, timeout_s: float) -> bool:
        """Whether nobody executes the fit any more, waiting for that a little."""
        try:
            handle = os.open(self.fit(fit_id), os.O_RDONLY | os.O_DIRECTORY)
        except FileNotFoundError:
            return True
        deadline = time.monotonic() + timeout_s
        try:
            while True:
                try:
                    fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    return True
                except BlockingIOError:
                    if time.monotonic() > deadline:
                        return False
                    time.sleep(0.01)
        finally:
            os.close(handle)

    def remove(self, place: str) -> None:
        """Removes the place with all it holds; one that is not there is no error.

        Raises OSError when something is left of it.
        """
        folder = self.root / place
        moved = self._moved(folder)
        errors = []
        with self._removing:
            with suppress(OSError):  # there is no room for another name, or something is mounted there
                os.replace(folder, moved)
            for one in (moved, folder):
                try:
                    _remove_tree(one)
                except OSError as error:
                    errors.append(error)
        if errors:
            raise errors[0]

    def left_of(self, place: str) -> str:
        """For people: where that is which could not be removed."""
        moved = self._moved(self.root / place)
        return str(moved if os.path.lexists(moved) else self.root / place)

    def is_empty(self) -> bool:
        """Whether no scan, no fit and no share is kept."""
        return not any(os.listdir(self.root / kind) for kind in PLACES)

    def count_unknown(self, known: Collection[str]) -> int:
        """Entries that are neither of the places `known` nor such ones on their way out."""
        ours = {self.root / place for place in known}
        ours |= {self._moved(folder) for folder in ours}
        return sum(entry not in ours for kind in (*PLACES, RUBBISH) for entry in (self.root / kind).iterdir())

    def _moved(self, folder: Path) -> Path:
        """The folder's name on its way out: known from the place alone, so that nothing else is removed for it."""
        return self._rubbish / f"{folder.parent.name}.{folder.name}"


def _remove_tree(path: Path) -> None:
    """Removes as much as can be removed, never what a link leads to.  Raises OSError when something is left."""
    if path.is_symlink() or not path.is_dir():
        path.unlink(missing_ok=True)
        return
    shutil.rmtree(path, ignore_errors=True)
    if os.path.lexists(path):
        shutil.rmtree(path)  # once more, to hear what is in the way
