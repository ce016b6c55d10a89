"""Where the files of scans, fits and share links are kept: on the disk, or in a store such as S3.

The rest of the program sees the same three things of both: a folder on this machine to read from, one to write into
whose content is kept when it is whole, and an opened file to answer with.

A place is `scans/ID`, `fits/ID` or `shares/ID`.
"""

from collections.abc import Callable, Collection
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Protocol


def scan_place(scan_id: str) -> str:
    return f"scans/{scan_id}"


def fit_place(fit_id: str) -> str:
    return f"fits/{fit_id}"


def share_place(snapshot_id: str) -> str:
    """Of what one share link shows."""
    return f"shares/{snapshot_id}"


def upload_name(file_type: str) -> str:
    """The name of the scan itself in its place."""
    return f"scan.{file_type}"


MESH = "mesh.glb"  # the scan for display
THUMBNAIL = "thumbnail.png"  # a small picture of it
MODELS = "models"  # the place of the models that fits were made with, which are nobody's data
ROOT = ""  # the place of the mark, which says whose all these files are
MARK = "installation"  # its name; what it holds is the installation's id


@dataclass(frozen=True)
class OpenedFile:
    """One kept file, about to be answered with; nothing of its content has been read."""

    path: Path | None  # where it is on this machine's disk; None: in a store
    size: int
    etag: str  # another one whenever the content is another
    open: Callable[[], IO[bytes]]  # seekable; OSError when it was deleted meanwhile


class Draft(Protocol):
    """A folder to write into, whose files are nobody's until they are kept."""

    @property
    def folder(self) -> Path:
        """This block's own."""

    def keep(self) -> None:
        """Puts the folder's files where others find them.  Raises OSError."""

    def take_back(self) -> None:
        """Undoes `keep`, when what the files belong to has gone or ended otherwise."""


class Locks(Protocol):
    """Who executes a fit: so that whoever deletes it can wait until nothing more is written."""

    def held(self, fit_id: str) -> AbstractContextManager[None]:
        """Marks the fit as being executed, until the block ends or the process dies; waits for who has it."""

    def wait_until_free(self, fit_id: str, timeout_s: float) -> bool:
        """Whether nobody executes the fit any more, waiting for that a little."""


class Files(Protocol):
    """May be used from any thread."""

    def create(self) -> None:
        """What has to be there before anything is kept.

        Raises BadSettings, also when others keep files there; then nothing was written.
        """

    def make(self, place: str) -> None:
        """Before anything is put there."""

    def reading(self, place: str, names: Collection[str] | None = None) -> AbstractContextManager[Path]:
        """A folder with these of the place's files (None: all); to be read only, and only inside the block.

        Files that are not there are not in it.
        """

    def writing(self, place: str) -> AbstractContextManager[Draft]:
        """A folder of this block to write into."""

    def find(self, place: str, name: str) -> OpenedFile | None:
        """The file, if it is there."""

    def write(self, place: str, name: str, content: bytes) -> None:
        """Keeps one file, whole or not at all.  Raises OSError."""

    def is_empty(self) -> bool:
        """Whether no scan, no fit and no share is kept."""

    def remove(self, place: str) -> None:
        """Removes the place with all it holds; one that is not there is no error.

        Raises OSError when something is left of it.
        """

    def left_of(self, place: str) -> str:
        """For people: where that is which could not be removed."""

    def count_unknown(self, known: Collection[str]) -> int:
        """How many scans, fits and shares seem to be kept that are not among these places; nobody removes them."""
