"""Files on the disk, in the folders of the data folder themselves: nothing is copied."""

import os
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from breastrig.storage.files import OpenedFile
from breastrig.storage.folders import Folders


@dataclass(frozen=True)
class FolderDraft:
    """The fit's own folder: its files count once the fit is done."""

    folder: Path

    def keep(self) -> None:
        pass

    def take_back(self) -> None:
        pass


class DiskFiles:
    """The Files of a data folder."""

    def __init__(self, folders: Folders) -> None:
        self._folders = folders

    def create(self) -> None:
        pass

    def make(self, place: str) -> None:
        self._folders.make(self._folder(place))

    @contextmanager
    def reading(self, place: str, names: Collection[str] | None = None) -> Iterator[Path]:
        yield self._folder(place)

    @contextmanager
    def writing(self, place: str) -> Iterator[FolderDraft]:
        yield FolderDraft(self._folder(place))

    def find(self, place: str, name: str) -> OpenedFile | None:
        path = self._folder(place) / name
        try:
            facts = path.stat()
        except FileNotFoundError:
            return None
        return OpenedFile(path, facts.st_size, f"{facts.st_mtime_ns:x}-{facts.st_size:x}", lambda: path.open("rb"))

    def write(self, place: str, name: str, content: bytes) -> None:
        path = self._folder(place) / name
        partial = path.with_name(f"{name}.part")
        try:
            partial.write_bytes(content)
            os.replace(partial, path)
        except OSError:
            partial.unlink(missing_ok=True)
            raise

    def is_empty(self) -> bool:
        return self._folders.are_empty()

    def remove(self, place: str) -> None:
        self._folders.remove(self._folder(place))

    def left_of(self, place: str) -> str:
        return str(self._folders.left_of(self._folder(place)))

    def count_unknown(self, known: Collection[str]) -> int:
        return self._folders.count_unknown(known)

    def _folder(self, place: str) -> Path:
        return self._folders.root / place
