"""What is not known of fits of versions that kept no hashes."""

import sys
from pathlib import Path

from breastrig.workflow.folder.earlier_fits import unchecked


def say_unchecked(*folders: Path | None) -> None:
    """A sentence for each on stderr."""
    for sentence in unchecked(folders):
        print(f"breastrig: {sentence}", file=sys.stderr)
