"""A disk of its own that is soon full, and folders that cannot be emptied: as far as this machine lets the tests."""

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

BLOCK = 4096


@contextmanager
def small_disk(place: Path, megabytes: int) -> Iterator[Path]:
    """An empty disk at that place; skips the test where only root can mount one."""
    place.mkdir()
    if os.geteuid():
        pytest.skip("only root can mount a small disk")
    _mount("-t", "tmpfs", "-o", f"size={megabytes}m", "tmpfs", str(place))
    try:
        yield place
    finally:
        subprocess.run(["umount", "-l", str(place)], check=True)


def fill(disk: Path) -> Path:
    """Leaves not one block free; the file that takes all the space."""
    ballast = disk / "ballast"
    with ballast.open("ab", buffering=0) as file, suppress(OSError):
        while True:
            file.write(bytes(BLOCK))
    return ballast


@contextmanager
def stuck(folder: Path) -> Iterator[None]:
    """Until the end of the block nothing in the folder can be removed, nor the folder itself, wherever it is moved."""
    if os.geteuid():
        folder.chmod(0o500)
        try:
            yield
        finally:
            folder.chmod(0o700)
        return
    _mount("--bind", str(folder), str(folder))
    held = os.open(folder, os.O_RDONLY)
    try:
        _mount("-o", "remount,ro,bind", str(folder))
        yield
    finally:
        subprocess.run(["umount", "-l", os.readlink(f"/proc/self/fd/{held}")], check=True)
        os.close(held)


def _mount(*options: str) -> None:
    """Skips the test where that is not allowed."""
    if subprocess.run(["mount", *options], capture_output=True, check=False).returncode:
        pytest.skip("this machine lets nobody mount a disk")
