"""Reserve files beside the index that are removed on a full disk: SQLite needs room for its logs even to read.

One after the other is removed, so that a server can start several times on a disk that stays full.
"""

import os
from pathlib import Path

PIECES = 4
PIECE_BYTES = 262_144  # SQLite takes 32 kB to open a file, and 4 kB for each page that a deletion changes


def keep(folder: Path) -> None:
    """Creates the missing reserve files, as far as there is room."""
    for number in range(PIECES):
        piece = folder / f"index-ballast-{number}"
        try:
            if not piece.exists() or piece.stat().st_size < PIECE_BYTES:
                piece.touch(mode=0o600)
                piece.write_bytes(os.urandom(PIECE_BYTES))  # no disk can store it in less
        except OSError:
            piece.unlink(missing_ok=True)
            return


def give_up(folder: Path) -> bool:
    """Removes one reserve file; returns whether there was any."""
    there = sorted(folder.glob("index-ballast-*"))
    if there:
        there[-1].unlink()
    return bool(there)
