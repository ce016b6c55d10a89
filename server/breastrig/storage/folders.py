"""The files of scans and fits: one folder each, named by an unguessable id, below the data folder.

    data/breastrig.sqlite3      rows, unless they are elsewhere (see `location`)
    data/scans/ID/              scan.ply, .obj, ... (the bytes as uploaded), mesh.glb (for display),
                                plain.glb (the same without colours, for share links)
    data/fits/ID/               result.json, scan.ply (cleaned), fitted.ply, fitted.glb, drawing.json,
                                distances.bin, fit.log.jsonl
    data/rubbish/               on its way out: a folder is first moved here, so that no path into it works any more

Original file names are never stored.
"""

import fcntl
import os
import secrets
import shutil
import time
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path


def new_id() -> str:
    """128 random bits as 22 URL-safe characters."""
    return secrets.token_urlsafe(16)


class Folders:
    """Paths below one data folder; only its owner can read them."""

    def __init__(self, root: Path) -> None:
        self.root = root

    def create(self) -> None:
        for folder in (self.root, self._scans, self._fits, self._rubbish):
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)

    @property
    def lock(self) -> Path:
        return self.root / "lock"

    @property
    def _scans(self) -> Path:
        return self.root / "scans"

    @property
    def _fits(self) -> Path:
        return self.root / "fits"

    @property
    def _rubbish(self) -> Path:
        return self.root / "rubbish"

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

    def remove(self, *folders: Path) -> None:
        """Removes the folders with all they hold; a folder that is not there is no error."""
        for folder in folders:
            try:
                os.replace(folder, self._rubbish / secrets.token_urlsafe(16))
            except FileNotFoundError:
                continue
        self.empty_rubbish()

    def empty_rubbish(self) -> None:
        for folder in self._rubbish.iterdir():
            shutil.rmtree(folder, ignore_errors=True)  # another thread may be at the same folder

    def are_empty(self) -> bool:
        """Whether there is no folder of a scan or fit."""
        return not any(True for kind in (self._scans, self._fits) for _ in kind.iterdir())

    def remove_strangers(self, known: Collection[str]) -> None:
        """Removes every folder of a scan or fit that is not among `known` (as scans/ID, fits/ID)."""
        found = (folder for kind in (self._scans, self._fits) for folder in kind.iterdir())
        self.remove(*(folder for folder in found if folder.relative_to(self.root).as_posix() not in known))
