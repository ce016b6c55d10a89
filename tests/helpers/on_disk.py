"""What really stands on the disk, read by another process.

A process that itself opens and closes a file of an open SQLite database loses its locks on it (POSIX releases
them with any descriptor); other processes then cut the file off under its feet, which ends in a bus error.
"""

import os
import subprocess
import sys
from pathlib import Path

from breastrig.audit.log import FOLDER
from breastrig.storage.files import MODELS


def bytes_below(root: Path, pattern: str = "**/*", besides: str = "") -> bytes:
    """All files below `root` that fit the pattern, one after the other, but for those of one folder in it."""
    files = [path for path in sorted(root.glob(pattern)) if path.is_file()]
    names = [str(path) for path in files if path.parent.name != besides or path.parent.parent != root]
    # what is named no longer was put aside by a server that runs
    return subprocess.run(["cat", os.devnull, *names], capture_output=True, check=False).stdout


def of_patients(data: Path) -> list[Path]:
    """What stands in the places of a data folder, but for the models and the audit log, which are nobody's data."""
    return [path for path in data.glob("*/*") if path.parent.name not in (MODELS, FOLDER)]


def overwrite(file: Path, first: int, last: int) -> None:
    """Damages a file of a database that is open, from a byte to before another."""
    write = f"file = open({str(file)!r}, 'r+b'); file.seek({first}); file.write(b'\\xa5' * {last - first})"
    subprocess.run([sys.executable, "-c", write], check=True)


def kept_below(root: Path) -> bytes:
    """Everything that is kept, names and contents, but for the audit log, which keeps ids."""
    return b" ".join(str(path).encode() for path in root.rglob("*")) + bytes_below(root, besides=FOLDER)
