"""What a command says beside its results."""

import sys


def say(*sentences: object) -> None:
    """A line each on stderr."""
    for sentence in sentences:
        print(f"breastrig: {sentence}", file=sys.stderr)
