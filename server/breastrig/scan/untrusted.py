"""Untrusted bytes: a file's, within the limit, and a parser of them, whatever goes wrong inside it."""

import stat
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from breastrig.core.errors import BadInput, BadScan, TooLarge
from breastrig.scan.limits import FILE_BYTES, MEBIBYTE

SHOWN_NAME = 60  # characters of a file's name in a sentence
Parsed = TypeVar("Parsed")


def bytes_of(source: Path | bytes) -> bytes:
    if isinstance(source, bytes):
        _check_size(len(source))
        return source
    shown = source.name if len(source.name) <= SHOWN_NAME else f"{source.name[:SHOWN_NAME]}..."
    try:
        facts = source.stat()
        if not stat.S_ISREG(facts.st_mode):
            raise BadScan(f"What is called {shown} is no ordinary file; give a scan file.")
        _check_size(facts.st_size)
        return source.read_bytes()
    except (OSError, ValueError) as error:
        reason = (isinstance(error, OSError) and error.strerror) or "no such name is possible"
        raise BadScan(f"The file {shown} cannot be read ({reason}); check the name.") from error


def _check_size(size: int) -> None:
    if size > FILE_BYTES:
        raise TooLarge(f"This file has {size // MEBIBYTE:,} MB, more than the {FILE_BYTES // MEBIBYTE} MB allowed.")


def guarded(kind: str, parse: Callable[[], Parsed]) -> Parsed:
    """The result of a parser of untrusted bytes; any exception becomes BadScan or TooLarge."""
    try:
        return parse()
    except BadInput:
        raise
    except MemoryError as error:
        raise TooLarge("Reading this scan needs more memory than there is; simplify it first.") from error
    except Exception as error:  # it can raise anything
        raise BadScan(f"This {kind.upper()} file is damaged or cut off and cannot be read; export it again.") from error
