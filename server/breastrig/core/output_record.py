"""The record of an output: what a run wrote, so that a later run knows what it may replace.

It stands in one of the run's JSON documents under "written": the SHA-256 of each file beside it, and of the document
itself.  Records of versions that did not write this count by their schema.
"""

import hashlib
import json
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from typing import Any

from breastrig.core.notice import LIMITS_OF_USE
from breastrig.core.private_files import is_ordinary, write_private

WRITTEN = "written"  # key of the record
RECORD_BYTES = 50_000_000  # a result.json has some ten thousand, an export's surface.json one million


@dataclass(frozen=True)
class OutputSet:
    """Files that a command writes together into one folder."""

    folder: Path  # relative to the output's folder
    names: tuple[str, ...]
    record: str | None = None  # the one that says what was written
    schema: str = ""  # of the record
    _: KW_ONLY
    varying: bool = False  # files of other names may come; those of an earlier run that do not come again are removed
    known: Callable[[Path], bool] = lambda _file: False  # what no record says: whether an earlier run wrote the file


def recorded(record: bytes, files: dict[str, bytes]) -> bytes:
    """The JSON document with what was written beside it; `files` are the others, by name."""
    document = json.loads(record)
    document.pop(WRITTEN, None)
    hashes = {name: hashlib.sha256(content).hexdigest() for name, content in files.items()}
    document[WRITTEN] = {"files": hashes, "document": _document_hash(document)}
    return (json.dumps(document, indent=1, allow_nan=False) + "\n").encode()


def write_record(folder: Path, one: OutputSet) -> None:
    """Writes into the record what stands beside it."""
    if one.record is None or not (folder / one.record).is_file():
        return
    try:
        others = (name for name in one.names if name != one.record and is_ordinary(folder / name))
        record = recorded((folder / one.record).read_bytes(), {name: (folder / name).read_bytes() for name in others})
    except ValueError:  # no JSON
        return
    write_private(folder / one.record, record)


def written_earlier(folder: Path, one: OutputSet) -> Callable[[str], bool]:
    """Whether a file of this name in the folder is what an earlier run wrote."""
    record = None if one.record is None else _json_object(folder / one.record)
    if record is None:
        return lambda name: one.known(folder / name)
    written = record.pop(WRITTEN, None)
    if not isinstance(written, dict):  # an earlier version, or another program's document
        same_kind = bool(one.schema) and record.get("schema") == one.schema

        def by_schema(name: str) -> bool:
            fits = same_kind and (name == one.record or _earlier_kind(folder / name))
            return fits or one.known(folder / name)

        return by_schema
    hashes = written.get("files")

    def by_hash(name: str) -> bool:
        if (folder / name).is_symlink():
            return False
        if name == one.record:
            return written.get("document") == _document_hash(record)
        return isinstance(hashes, dict) and name in hashes and hashes[name] == _file_hash(folder / name)

    return by_hash


def unchanged_files(folder: Path, one: OutputSet) -> list[Path]:
    """The files beside the set's record that stand in it and are as they were written."""
    record = _json_object(folder / one.folder / one.record) if one.record else None
    written = record.get(WRITTEN) if record else None
    hashes = written.get("files") if isinstance(written, dict) else None
    if not isinstance(hashes, dict):
        return []
    places = {folder / one.folder / name: found for name, found in hashes.items() if ".." not in Path(name).parts}
    return [place for place, found in places.items() if not place.is_symlink() and _file_hash(place) == found]


def _document_hash(document: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()


def _earlier_kind(file: Path) -> bool:
    """Whether it can be a companion of a record without hashes: a JSON document must bear our notice."""
    if file.is_symlink():
        return False
    if file.suffix != ".json":
        return True
    document = _json_object(file)
    return document is not None and document.get("notice") == LIMITS_OF_USE


def _json_object(file: Path) -> dict[str, Any] | None:
    try:
        if not is_ordinary(file) or file.stat().st_size > RECORD_BYTES:
            return None
        document = json.loads(file.read_bytes())
    except (OSError, ValueError, RecursionError):
        return None
    return document if isinstance(document, dict) else None


def _file_hash(file: Path) -> str | None:
    try:
        with file.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError:
        return None
