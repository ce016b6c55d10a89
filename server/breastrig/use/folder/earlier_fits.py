"""Reads fits of versions that stored no hashes, and reports what could not be checked."""

from collections.abc import Iterable
from pathlib import Path

from breastrig.core.errors import BadInput
from breastrig.files.result import folder_name, read_result


def unchecked(folders: Iterable[str | Path | None]) -> tuple[str, ...]:
    """A sentence for each folder whose result.json has no hashes; none for what is no fit."""
    said = []
    for folder in (Path(each) for each in folders if each is not None):
        try:
            kept = bool(read_result(folder).files)
        except BadInput:
            continue  # what is done with it says what is wrong
        if not kept:
            said.append(
                f"{folder_name(folder)} is a fit of an earlier version, which kept no hashes: whether its files belong "
                "together is not known. Fit the scan again to be sure."
            )
    return tuple(said)
