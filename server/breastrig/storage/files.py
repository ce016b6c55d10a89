"""Names and places of what is kept of scans, fits and share links: `scans/ID`, `fits/ID`, `shares/ID`."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import IO


def scan_place(scan_id: str) -> str:
    return f"scans/{scan_id}"


def fit_place(fit_id: str) -> str:
    return f"fits/{fit_id}"


def share_place(snapshot_id: str) -> str:
    """The place of a share link's files."""
    return f"shares/{snapshot_id}"


def upload_name(file_type: str) -> str:
    """The file name of the scan itself in its place."""
    return f"scan.{file_type}"


MESH = "mesh.glb"  # the scan for display
THUMBNAIL = "thumbnail.png"  # a small picture of it
VOLUME = "volume.npz"  # the image that the scan's skin was made of, where it was made of one
MODELS = "models"  # the place of the models that fits were made with, which are nobody's data
ROOT = ""  # the place of the mark, which says whose all these files are
MARK = "installation"  # its name; what it holds is the installation's id


@dataclass(frozen=True)
class OpenedFile:
    """A stored file, about to be sent; nothing of its content has been read."""

    path: Path | None  # where it is on the disk; None: in memory
    size: int
    etag: str  # another one whenever the content is another
    open: Callable[[], IO[bytes]]  # seekable; OSError when it was deleted meanwhile
