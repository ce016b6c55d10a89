"""Results that appear together or not at all.

They are first written into a private folder beside their places, and put there when all of them are complete; a
command that fails or is stopped leaves what was there.
"""

import os
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path

from breastrig.core.output_files import Output, check_output, resolved, unwritable
from breastrig.core.output_record import unchanged_files, write_record
from breastrig.core.private_files import private_folder, remove_partial_files
from breastrig.core.scratch import held_folder, remove_abandoned

PART = ".breastrig-part-"  # of the folder in which results are written


@contextmanager
def all_or_nothing(output: Output) -> Iterator[Path]:
    """A private folder to write into; its files are put into the output's folder at the end, or nothing is.

    Raises BadInput, at the start when the output cannot be had, at the end when it could not be put in place.
    """
    check_output(output)
    output = resolved(output)
    made: list[Path] = []
    done = False
    try:
        with ExitStack() as stack:
            try:
                made = private_folder(output.folder)
                remove_abandoned(output.folder, PART)
                remove_partial_files(output.folder)
                staging = stack.enter_context(held_folder(output.folder, PART))
                results = staging / "new"
                results.mkdir(mode=0o700)
            except OSError as error:
                raise unwritable(output.folder, error) from error
            yield results
            output.stopped()
            _put_in_place(output, results, staging / "old")
            done = True
    finally:
        if not done:
            _remove_empty(made)


def _put_in_place(output: Output, results: Path, backup: Path) -> None:
    """Moves the results to their places; if that fails, what was there is there again."""
    undo: list[tuple[Path, Path | None]] = []
    folders: list[Path] = []
    try:
        files = sorted(each for each in results.rglob("*") if each.is_file())
        names = tuple(file.relative_to(results).as_posix() for file in files)
        sets = tuple(replace(one, names=names) if one.varying else one for one in output.sets)
        for one in sets:
            write_record(results / one.folder, one)
        check_output(replace(output, sets=sets))
        earlier = [place for one in sets if one.varying for place in unchanged_files(output.folder, one)]
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
            raise unwritable(output.folder, error) from error
        raise


def _second_name(file: Path, name: Path) -> None:
    """The file under another name as well; a link is moved, and so is a file where there are no hard links."""
    if file.is_symlink():
        os.replace(file, name)
        return
    try:
        os.link(file, name)
    except OSError:
        os.replace(file, name)


def _remove_empty(folders: Iterable[Path]) -> None:
    """Folders that were made for nothing."""
    for folder in reversed(list(folders)):
        with suppress(OSError):
            folder.rmdir()
