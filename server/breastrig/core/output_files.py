"""Where a command leaves its results: never over what it reads, nor over what somebody else made.

Results are first written into a private folder beside their places, and put there when all of them are complete; a
command that fails or is stopped leaves what was there.  Whoever asks for an output is told before the work starts
whether it can be had:

* a file that the command reads is never replaced, under whatever name or link it is reached;
* any other file is replaced only if an earlier run wrote it and nobody changed it since, or if the user says so
  (`force`).  What a run wrote stands in one of its JSON documents, the record, under "written": the SHA-256 of each
  file beside it, and of the document itself.  Records of versions that did not write this count by their schema.

Results show patients: files are for their owner only (0600), so are folders that are made for them (0700), whatever
the umask says.  A folder that was there keeps its mode.
"""

import errno
import hashlib
import json
import os
import shutil
import stat
import tempfile
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import KW_ONLY, dataclass, replace
from fcntl import LOCK_EX, LOCK_NB, flock
from pathlib import Path
from typing import Any

from breastrig.core.errors import BadInput
from breastrig.core.notice import LIMITS_OF_USE

WRITTEN = "written"  # key of the record
PREFIX = ".breastrig-part-"  # of the folder in which results are completed
RECORD_BYTES = 50_000_000  # a result.json has some ten thousand, an export's surface.json one million
SHOWN = 3  # names of files in one sentence


@dataclass(frozen=True)
class OutputSet:
    """Files that a command writes together into one folder."""

    folder: Path  # relative to the output's folder
    names: tuple[str, ...]
    record: str | None = None  # the one that tells what was written
    schema: str = ""  # of the record
    _: KW_ONLY
    varying: bool = False  # files of other names may come; those of an earlier run that do not come again are removed
    known: Callable[[Path], bool] = lambda _file: False  # what no record tells: whether an earlier run wrote the file


@dataclass(frozen=True)
class Output:
    """What a command is about to write, and what it must not touch."""

    folder: Path
    sets: tuple[OutputSet, ...]
    inputs: tuple[Path, ...]  # files that the command reads; those that do not exist are passed over
    force: bool = False
    stopped: Callable[[], None] = lambda: None  # asked before results are put in place; raises to leave all as it was


def single_file(file: Path, inputs: Iterable[Path], force: bool, stopped: Callable[[], None] = lambda: None) -> Output:
    """One file; a JSON document is its own record, any other kind is replaced by force only."""
    if file.name in ("", ".."):
        raise BadInput(f"{shown(file)} is no name of a file; give one with -o.")
    record = file.name if file.suffix.lower() == ".json" else None
    return Output(file.parent, (OutputSet(Path(), (file.name,), record),), tuple(inputs), force, stopped)


def check_output(output: Output) -> None:
    """Raises BadInput when the results could not be written, or would replace what they must not."""
    output = _resolved(output)
    _check_folder(output.folder)
    ids = _identities(output.inputs)
    foreign: list[str] = []
    for one in output.sets:
        _check_folder(output.folder / one.folder)
        written = _written(output.folder / one.folder, one)
        for name in one.names:
            file = output.folder / one.folder / name
            _check_replaceable(file, ids)
            if not output.force and os.path.lexists(file) and not written(name):
                foreign.append((one.folder / name).as_posix())
    if foreign:
        more = f" and {len(foreign) - SHOWN} more" if len(foreign) > SHOWN else ""
        raise BadInput(
            f"{shown(output.folder)} holds {', '.join(foreign[:SHOWN])}{more}, not written by BreastRig or changed "
            "since; choose another place with -o, or replace with --force."
        )


@contextmanager
def all_or_nothing(output: Output) -> Iterator[Path]:
    """A private folder to write into; its files are put into the output's folder at the end, or nothing is.

    Raises BadInput, at the start when the output cannot be had, at the end when it could not be put in place.
    """
    check_output(output)
    output = _resolved(output)
    made: list[Path] = []
    try:
        made = private_folder(output.folder)
        _remove_leftovers(output.folder)
        staging, handle = _locked_folder(output.folder)
    except OSError as error:
        _remove_empty(made)
        raise _unwritable(output.folder, error) from error
    done = False
    try:
        results = staging / "new"
        results.mkdir(mode=0o700)
        yield results
        output.stopped()
        _put_in_place(output, results, staging / "old")
        done = True
    finally:
        shutil.rmtree(staging, ignore_errors=True)
        os.close(handle)
        if not done:
            _remove_empty(made)


def check_inputs_kept(files: Iterable[Path], inputs: Collection[Path]) -> None:
    """Raises BadInput when one of the files is one of the inputs, or is no file."""
    ids = _identities(inputs)
    for file in files:
        _check_replaceable(file, ids)


def private_folder(folder: Path) -> list[Path]:
    """Makes the folder and those above it that are missing, for their owner only; those made, outermost first."""
    folder = folder.absolute()
    missing = [folder, *folder.parents]
    missing = missing[: next((k for k, each in enumerate(missing) if each.is_dir()), len(missing))]
    for each in reversed(missing):
        each.mkdir(mode=0o700)
        each.chmod(0o700)
    return missing[::-1]


def write_private(file: Path, content: bytes) -> None:
    """Writes a file for its owner only, whole or not at all, in the place of an older one."""
    handle, name = tempfile.mkstemp(prefix=PREFIX, dir=file.parent)  # 0600
    try:
        with os.fdopen(handle, "wb") as partial:
            _locked(handle)
            partial.write(content)
            partial.flush()
            os.replace(name, file)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def recorded(record: bytes, files: dict[str, bytes]) -> bytes:
    """The JSON document with what was written beside it; `files` are the others, by name."""
    document = json.loads(record)
    document.pop(WRITTEN, None)
    hashes = {name: hashlib.sha256(content).hexdigest() for name, content in files.items()}
    document[WRITTEN] = {"files": hashes, "document": _document_hash(document)}
    return (json.dumps(document, indent=1, allow_nan=False) + "\n").encode()


def is_ordinary(file: Path) -> bool:
    """Whether it is a file that can be read to its end: no folder, pipe or device, no name that cannot be."""
    try:
        return stat.S_ISREG(file.stat().st_mode)
    except (OSError, ValueError):
        return False


def read_ordinary(file: Path, limit: int) -> bytes:
    """The file's bytes, at most one more than the limit; OSError at once for a pipe, a device or a folder."""
    handle = os.open(file, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    with os.fdopen(handle, "rb") as stream:
        if not stat.S_ISREG(os.fstat(handle).st_mode):
            raise OSError(errno.EINVAL, "it is no ordinary file", str(file))
        return stream.read(limit + 1)


def shown(path: Path | str) -> str:
    """The path for a sentence: as it was given, shortened in the middle if it is very long."""
    text = str(path)
    return text if len(text) <= 200 else f"{text[:90]} ... {text[-90:]}"


def _document_hash(document: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()


def _written(folder: Path, one: OutputSet) -> Callable[[str], bool]:
    """Whether a file of this name in the folder is what an earlier run wrote."""
    record = None if one.record is None else _json_object(folder / one.record)
    if record is None:
        return lambda name: one.known(folder / name)
    written = record.pop(WRITTEN, None)
    if not isinstance(written, dict):  # an earlier version, or somebody else's document
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


def _unchanged_files(folder: Path, one: OutputSet) -> list[Path]:
    """The files beside the set's record that stand in it and are as they were written."""
    record = _json_object(folder / one.folder / one.record) if one.record else None
    written = record.get(WRITTEN) if record else None
    hashes = written.get("files") if isinstance(written, dict) else None
    if not isinstance(hashes, dict):
        return []
    places = {folder / one.folder / name: found for name, found in hashes.items() if ".." not in Path(name).parts}
    return [place for place, found in places.items() if not place.is_symlink() and _file_hash(place) == found]


def _identities(files: Collection[Path]) -> dict[tuple[int, int], Path]:
    """Device and inode of the files that exist, so that links of both kinds are known."""
    found = {}
    for file in files:
        with suppress(OSError, ValueError):
            about = file.stat()
            found[about.st_dev, about.st_ino] = file
    return found


def _resolved(output: Output) -> Output:
    """With the folder as it is on the disk: x/.. is a folder also where there is no x."""
    try:
        return replace(output, folder=output.folder.resolve())
    except (OSError, RuntimeError, ValueError) as error:  # RuntimeError: a loop of links, before Python 3.13
        raise _unwritable(output.folder, error) from error


def _check_replaceable(file: Path, inputs: dict[tuple[int, int], Path]) -> None:
    """Raises BadInput for an input, and for what is no file."""
    try:
        about = file.stat()
    except FileNotFoundError:
        return  # nothing is there, or a link that leads nowhere
    except OSError as error:
        raise _unwritable(file, error) from error
    if (about.st_dev, about.st_ino) in inputs:
        source = inputs[about.st_dev, about.st_ino]
        raise BadInput(
            f"{shown(file)} would replace {shown(source)}, which this command reads; choose another place with -o."
        )
    if not stat.S_ISREG(about.st_mode):
        raise BadInput(f"{shown(file)} is there already and is no ordinary file; choose another place with -o.")


def _check_folder(folder: Path) -> None:
    """Raises BadInput when no folder can be there, or nothing be written into it."""
    try:
        for each in (folder, *folder.absolute().parents):
            if os.path.lexists(each):
                if not each.is_dir():
                    raise BadInput(f"{shown(each)} is no folder; choose another place with -o.")
                if not os.access(each, os.W_OK | os.X_OK):
                    raise BadInput(f"{shown(each)} cannot be written to; choose another place with -o.")
                return
            if len(os.fsencode(each.name)) > 255:
                raise BadInput(f"{shown(folder)} is too long a name for a folder; choose another place with -o.")
    except (OSError, ValueError) as error:
        raise _unwritable(folder, error) from error


def _put_in_place(output: Output, results: Path, backup: Path) -> None:
    """Moves the results to their places; if that fails, what was there is there again."""
    undo: list[tuple[Path, Path | None]] = []
    folders: list[Path] = []
    try:
        files = sorted(each for each in results.rglob("*") if each.is_file())
        names = tuple(file.relative_to(results).as_posix() for file in files)
        sets = tuple(replace(one, names=names) if one.varying else one for one in output.sets)
        for one in sets:
            _record(results / one.folder, one)
        check_output(replace(output, sets=sets))
        earlier = [place for one in sets if one.varying for place in _unchanged_files(output.folder, one)]
        for file in files:
            place = output.folder / file.relative_to(results)
            folders += private_folder(place.parent)
            file.chmod(0o600)
            before = None
            if os.path.lexists(place):
                backup.mkdir(mode=0o700, exist_ok=True)
                before = backup / str(len(undo))
                _second_name(place, before)
            undo.append((place, before))
            os.replace(file, place)
        for place in set(earlier) - {output.folder / name for name in names}:
            place.unlink(missing_ok=True)
    except BaseException as error:
        for place, before in reversed(undo):
            with suppress(OSError):
                if before is not None:
                    os.replace(before, place)
                else:
                    place.unlink(missing_ok=True)
        _remove_empty(folders)
        if isinstance(error, OSError):
            raise _unwritable(output.folder, error) from error
        raise


def _record(folder: Path, one: OutputSet) -> None:
    """Writes into the record what stands beside it."""
    if one.record is None or not (folder / one.record).is_file():
        return
    try:
        others = (name for name in one.names if name != one.record and is_ordinary(folder / name))
        record = recorded((folder / one.record).read_bytes(), {name: (folder / name).read_bytes() for name in others})
    except ValueError:  # no JSON
        return
    write_private(folder / one.record, record)


def _second_name(file: Path, name: Path) -> None:
    """The file under another name as well; a link is moved, and so is a file where there are no hard links."""
    if file.is_symlink():
        os.replace(file, name)
        return
    try:
        os.link(file, name)
    except OSError:
        os.replace(file, name)


def _locked_folder(folder: Path) -> tuple[Path, int]:
    """A new private folder inside, and a handle that holds a lock on it: who finds one unlocked may remove it."""
    while True:
        staging = Path(tempfile.mkdtemp(prefix=PREFIX, dir=folder))  # 0700
        with suppress(FileNotFoundError):  # removed by another run before it was locked
            handle = os.open(staging, os.O_RDONLY | os.O_DIRECTORY)
            if _locked(handle) and staging.is_dir():
                return staging, handle
            os.close(handle)


def _locked(handle: int) -> bool:
    """Locks for as long as the handle is open; True also where the file system knows no locks."""
    try:
        flock(handle, LOCK_EX | LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True


def _remove_leftovers(folder: Path) -> None:
    """What a killed run left half-done; a run that is at work holds a lock on its own."""
    for leftover in folder.glob(PREFIX + "*"):
        with suppress(OSError):
            handle = os.open(leftover, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
            try:
                flock(handle, LOCK_EX | LOCK_NB)
                if leftover.is_dir():
                    shutil.rmtree(leftover, ignore_errors=True)
                elif leftover.is_file():
                    leftover.unlink()
            finally:
                os.close(handle)


def _remove_empty(folders: Iterable[Path]) -> None:
    """Folders that were made for nothing."""
    for folder in reversed(list(folders)):
        with suppress(OSError):
            folder.rmdir()


def _unwritable(place: Path, error: Exception) -> BadInput:
    reason = getattr(error, "strerror", None) or "no such name can be"
    return BadInput(f"{shown(place)} cannot be written ({reason}); free space, or choose another place with -o.")
