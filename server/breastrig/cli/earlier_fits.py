"""Fits of versions that kept no hashes are read, and it is said what is not known of them."""

import sys
from collections.abc import Iterable
from pathlib import Path

from breastrig.core.errors import BadInput
from breastrig.files.result import folder_name, read_result


def unchecked(folders: Iterable[Path | None]) -> tuple[str, ...]:
    """A sentence for each folder whose result.json has no hashes; none for what is no fit."""
    said = []
    for folder in folders:
        try:
            kept = folder is None or bool(read_result(folder).files)
        except BadInput:
            continue  # the command says what is wrong with it
        if not kept and folder is not None:
            said.append(
                f"{folder_name(folder)} is a fit of an earlier version, which kept no hashes: whether its files belong "
                "together is not known. Fit the scan again to be sure."
            )
    return tuple(said)


def say_unchecked(*folders: Path | None) -> None:
    """The same on stderr."""
    for sentence in unchecked(folders):
        print(f"breastrig: {sentence}", file=sys.stderr)
