"""Where a command leaves its results: never over what it reads, nor over what another program or person made.

Whoever asks for an output learns before the work starts whether it can be had:

* a file that the command reads is never replaced, under whatever name or link it is reached;
* any other file is replaced only if an earlier run wrote it and nobody changed it since (see output_record.py), or if
  the user says so (`force`).
"""

import os
import stat
from collections.abc import Callable, Collection, Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from breastrig.core.errors import BadInput
from breastrig.core.output_record import OutputSet, written_earlier
from breastrig.core.private_files import shown

SHOWN = 3  # names of files in one sentence


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
    output = resolved(output)
    _check_folder(output.folder)
    ids = _identities(output.inputs)
    foreign: list[str] = []
    for one in output.sets:
        _check_folder(output.folder / one.folder)
        written = written_earlier(output.folder / one.folder, one)
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


def check_inputs_kept(files: Iterable[Path], inputs: Collection[Path]) -> None:
    """Raises BadInput when one of the files is one of the inputs, or is no file."""
    ids = _identities(inputs)
    for file in files:
        _check_replaceable(file, ids)


def resolved(output: Output) -> Output:
    """With the folder as it is on the disk: x/.. is a folder also where there is no x."""
    try:
        return replace(output, folder=output.folder.resolve())
    except (OSError, RuntimeError, ValueError) as error:  # RuntimeError: a loop of links, before Python 3.13
        raise unwritable(output.folder, error) from error


def unwritable(place: Path, error: Exception) -> BadInput:
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
        raise unwritable(file, error) from error
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
        raise unwritable(folder, error) from error
