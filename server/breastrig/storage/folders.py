"""The files of scans, fits and share links: one folder each, named by an unguessable id, below the data folder.

    data/installation           says that the folder is BreastRig's (see `data_folder`)
    data/breastrig.sqlite3      rows, unless they are elsewhere (see `location`)
    data/scans/ID/              scan.stored (what was read of the upload), mesh.glb (for display), thumbnail.png
    data/fits/ID/               result.json, scan.ply (cleaned), fitted.ply, fitted.glb, drawing.json,
                                distances.bin, uncertainty.bin, fit.log.jsonl
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
from breastrig.storage.files import MODELS


def new_id() -> str:
    """128 random bits as 22 URL-safe characters."""
    return secrets.token_urlsafe(16)


class Folders:
    """Paths below one data folder; only its owner can read them."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self._removing = threading.Lock()  # who finds a folder half removed would not know whether it will be gone

    def create(self) -> None:
        for folder in (self.root, *self._places, self._rubbish, self.root / MODELS):
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)

    @property
    def lock(self) -> Path:
        return self.root / LOCK_FILE

    @property
    def reserve(self) -> Path:
        return self.root / RESERVE_FILE

    @property
    def _places(self) -> list[Path]:
        return [self.root / name for name in PLACES]

    @property
    def _scans(self) -> Path:
        return self.root / "scans"

    @property
    def _fits(self) -> Path:
        return self.root / "fits"

    @property
    def _rubbish(self) -> Path:
        return self.root / RUBBISH

    def scan(self, scan_id: str) -> Path:
        return self._scans / scan_id

    def uploaded(self, scan_id: str, file_type: str) -> Path:
        return self.scan(scan_id) / f"scan.{file_type}"

    def mesh(self, scan_id: str) -> Path:
        return self.scan(scan_id) / "mesh.glb"

    def fit(self, fit_id: str) -> Path:
        return self._fits / fit_id

    def make(self, folder: Path) -> None:
        folder.mkdir(mode=0o700)

    @contextmanager
    def held(self, folder: Path) -> Iterator[None]:
        """Marks the folder as being written to, until the block ends or the process dies.

        Raises FileNotFoundError when it is gone.
        """
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX)
            yield
        finally:
            os.close(handle)

    def wait_until_free(self, folder: Path, timeout_s: float) -> bool:
        """Whether nobody holds the folder any more, waiting for that a little."""
        try:
            handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
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

    def remove(self, folder: Path) -> None:
        """Removes the folder with all it holds; one that is not there is no error.

        Raises OSError when something is left of it.
        """
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

    def left_of(self, folder: Path) -> Path:
        """Where that is which `remove` could not remove."""
        moved = self._moved(folder)
        return moved if os.path.lexists(moved) else folder

    def are_empty(self) -> bool:
        """Whether there is no folder of a scan, a fit or a share link."""
        return not any(os.listdir(kind) for kind in self._places)

    def count_unknown(self, known: Collection[str]) -> int:
        """How many entries are neither of the places `known` (such as scans/ID) nor such ones on their way out."""
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
