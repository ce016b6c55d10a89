"""Warns about fits of versions that stored no hashes."""

import sys
from pathlib import Path

from breastrig.use.folder.earlier_fits import unchecked


def say_unchecked(*folders: Path | None) -> None:
    """Prints a sentence for each such fit on stderr."""
    for sentence in unchecked(folders):
        print(f"breastrig: {sentence}", file=sys.stderr)
