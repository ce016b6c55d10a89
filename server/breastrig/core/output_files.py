"""Results of a command: all of them or none, never over what the command reads or what somebody else made.

They are written into a private folder beside their places and moved there when all are complete.  Files that are there
already are replaced if the folder holds an earlier result (its JSON record has the schema), or with `force`.
"""

import json
import os
import stat
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from breastrig.core.errors import BadInput
from breastrig.core.private_files import private_folder, read_ordinary, remove_partial_files, shown, write_private
from breastrig.core.scratch import locked_folder, remove_abandoned

SHOWN = 3  # names of files in one sentence
RECORD_BYTES = 50_000_000  # a result.json has some ten thousand, an export's surface.json one million
PART = ".breastrig-part-"  # of the folder in which results are written


@dataclass(frozen=True)
class OutputSet:
    """Files that a command writes together into one folder."""

    folder: Path  # relative to the output's folder
    names: tuple[str, ...]
    record: str = ""  # the JSON document whose schema shows that the folder holds an earlier result
    schema: str = ""
    varying: bool = False  # files of other names may come; the record lists them, and earlier ones are removed


@dataclass(frozen=True)
class Output:
    """The files that a command will write, and those that it must not touch."""

    folder: Path
    sets: tuple[OutputSet, ...]
    inputs: tuple[Path, ...]  # files that the command reads; those that do not exist are passed over
    force: bool = False
    stopped: Callable[[], None] = lambda: None  # asked before results are put in place; raises to leave all as it was


def single_file(file: Path, inputs: Iterable[Path], force: bool, stopped: Callable[[], None] = lambda: None) -> Output:
    """The output of one file; an existing one is replaced only with `force`."""
    if file.name in ("", ".."):
        raise BadInput(f"{shown(file)} is no name of a file; give one with -o.")
    return Output(file.parent, (OutputSet(Path(), (file.name,)),), tuple(inputs), force, stopped)


def check_output(output: Output) -> None:
    """Raises BadInput when the results could not be written, or would replace what they must not."""
    output = _resolved(output)
    _check_folder(output.folder)
    ids = _identities(output.inputs)
    foreign: list[str] = []
    for one in output.sets:
        folder = output.folder / one.folder
        _check_folder(folder)
        replaceable = output.force or _earlier(folder, one) is not None
        for name in one.names:
            _check_replaceable(folder / name, ids)
            if not replaceable and os.path.lexists(folder / name):
                foreign.append((one.folder / name).as_posix())
    if foreign:
        more = f" and {len(foreign) - SHOWN} more" if len(foreign) > SHOWN else ""
        raise BadInput(
            f"{shown(output.folder)} holds {', '.join(foreign[:SHOWN])}{more} already; choose another place with -o, "
            "or replace with --force."
        )


@contextmanager
def all_or_nothing(output: Output) -> Iterator[Path]:
    """A private folder to write into; its files are put into the output's folder at the end, or nothing is.

    Raises BadInput, at the start when the output cannot be had, at the end when it could not be put in place.
    """
    check_output(output)
    output = _resolved(output)
    made: list[Path] = []
    done = False
    try:
        with ExitStack() as stack:
            try:
                made = private_folder(output.folder)
                remove_abandoned(output.folder, PART)
                remove_partial_files(output.folder)
                staging = stack.enter_context(locked_folder(output.folder, PART))
                results = staging / "new"
                results.mkdir(mode=0o700)
            except OSError as error:
                raise _unwritable(output.folder, error) from error
            yield results
            output.stopped()
            check_output(output)
            _put_in_place(output, results, staging / "old")
            done = True
    finally:
        if not done:
            _remove_empty(made)


def _put_in_place(output: Output, results: Path, backup: Path) -> None:
    """Moves the results to their places; on failure restores what was there."""
    moved: list[Path] = []
    folders: list[Path] = []
    try:
        names = sorted(each.relative_to(results) for each in results.rglob("*") if each.is_file())
        stale = [name for one in output.sets if one.varying for name in _renewed(output.folder, one, results, names)]
        for name in names:
            folders += private_folder((output.folder / name).parent)
        for name in dict.fromkeys((*stale, *names)):
            moved.append(name)
            if os.path.lexists(output.folder / name):
                private_folder((backup / name).parent)
                os.replace(output.folder / name, backup / name)
            if name in names:
                (results / name).chmod(0o600)
                os.replace(results / name, output.folder / name)
    except BaseException as error:
        for name in reversed(moved):
            with suppress(OSError):
                if os.path.lexists(backup / name):
                    os.replace(backup / name, output.folder / name)
                else:
                    (output.folder / name).unlink(missing_ok=True)
        _remove_empty(folders)
        if isinstance(error, OSError):
            raise _unwritable(output.folder, error) from error
        raise


def _renewed(folder: Path, one: OutputSet, results: Path, names: Collection[Path]) -> list[Path]:
    """Lists the new files in the record; the files of the earlier record, which are to go unless they come again."""
    earlier = (_earlier(folder / one.folder, one) or {}).get("files")
    document = json.loads((results / one.folder / one.record).read_bytes())
    document["files"] = [name.relative_to(one.folder).as_posix() for name in names if name.is_relative_to(one.folder)]
    write_private(results / one.folder / one.record, (json.dumps(document, indent=1, allow_nan=False) + "\n").encode())
    listed = [Path(name) for name in earlier if isinstance(name, str)] if isinstance(earlier, list) else []
    return [one.folder / name for name in listed if not name.is_absolute() and ".." not in name.parts]


def _earlier(folder: Path, one: OutputSet) -> dict[str, Any] | None:
    """The record of an earlier result in the folder; None where there is none."""
    try:
        document = json.loads(read_ordinary(folder / one.record, RECORD_BYTES)) if one.record else None
    except (OSError, ValueError, RecursionError):
        return None
    return document if isinstance(document, dict) and document.get("schema") == one.schema else None


def _remove_empty(folders: Iterable[Path]) -> None:
    """Removes created folders that stayed empty."""
    for folder in reversed(list(folders)):
        with suppress(OSError):
            folder.rmdir()


def check_inputs_kept(files: Iterable[Path], inputs: Collection[Path]) -> None:
    """Raises BadInput when one of the files is one of the inputs, or is no file."""
    ids = _identities(inputs)
    for file in files:
        _check_replaceable(file, ids)


def _resolved(output: Output) -> Output:
    """The output with its real folder: x/.. is a folder also where there is no x."""
    try:
        return replace(output, folder=output.folder.resolve())
    except (OSError, RuntimeError, ValueError) as error:  # RuntimeError: a loop of links, before Python 3.13
        raise _unwritable(output.folder, error) from error


def _unwritable(place: Path, error: Exception) -> BadInput:
    reason = getattr(error, "strerror", None) or "no such name can be"
    return BadInput(f"{shown(place)} cannot be written ({reason}); free space, or choose another place with -o.")


def _identities(files: Collection[Path]) -> dict[tuple[int, int], Path]:
    """Device and inode of the files that exist, so that links of both kinds are known."""
    found = {}
    for file in files:
        with suppress(OSError, ValueError):
            about = file.stat()
            found[about.st_dev, about.st_ino] = file
    return found


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
