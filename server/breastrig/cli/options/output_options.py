"""Options of every command that writes results: -o, --force, and the files that are never overwritten."""

import argparse
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

from breastrig.cli.interruption import raise_if_asked
from breastrig.cli.messages.say import say
from breastrig.core.assets import model_path
from breastrig.core.output_files import Output, OutputSet, all_or_nothing, single_file
from breastrig.core.private_files import write_private
from breastrig.files.result import FIT_FILES
from breastrig.languages.catalogue import ENGLISH, LANGUAGES

FITS = ("fit", "other", "from_fit", "to_fit")  # options that are folders which `breastrig fit` wrote
MISFIT = 4  # exit code: all is written, but a pattern or an item does not fit on this patient


def say_misfits(reasons: Iterable[str]) -> int:
    """Prints on stderr each item that is not drawn, with the reason; returns the exit code, 0 where there is none."""
    said = tuple(reasons)
    say(*said)
    return MISFIT if said else 0


def add_output_options(parser: argparse.ArgumentParser, metavar: str, what: str) -> None:
    parser.add_argument("-o", "--output", type=Path, required=True, metavar=metavar, help=what)
    parser.add_argument(
        "--force", action="store_true", help="replace files that are no earlier result; never what the command reads"
    )


def add_plan_options(parser: argparse.ArgumentParser, shown: str) -> None:
    """A fit, another of the same patient, a plan that is `shown` (a participle), and the rig."""
    parser.add_argument("fit", type=Path, metavar="OUT", help="folder that `breastrig fit` wrote")
    parser.add_argument(
        "--with", dest="other", type=Path, metavar="OUT_B", help="fit of the same patient in another stance"
    )
    parser.add_argument(
        "--plan", type=Path, metavar="FILE", help=f"plan or drawing that is {shown} instead of the fit's own drawing"
    )
    add_model(parser, "the rig that the fits were made with")
    add_same_patient(parser)


def add_model(parser: argparse.ArgumentParser, what: str) -> None:
    parser.add_argument("--model", type=model_path, metavar="MODEL", help=what)


def add_same_patient(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--same-patient",
        action="store_true",
        help="all is one patient's: a plan or drawing whose file names another, or scans that do not look like one's",
    )


def add_language(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--language", choices=LANGUAGES, default=ENGLISH, help="of the pages (default en)")


def output_folder(options: argparse.Namespace, *sets: OutputSet, also_read: Iterable[Path] = ()) -> Output:
    """The command's folder for results."""
    return Output(options.output, sets, (*_read_by(options), *also_read), options.force, raise_if_asked)


def writing_folder(options: argparse.Namespace, *sets: OutputSet) -> AbstractContextManager[Path]:
    """A folder to write results into, all of which are put in place at the end, or none."""
    return all_or_nothing(output_folder(options, *sets))


@contextmanager
def writing_file(options: argparse.Namespace) -> Iterator[Callable[[bytes], None]]:
    """Writes the command's one file, which is put in place at the end."""
    with all_or_nothing(single_file(options.output, _read_by(options), options.force, raise_if_asked)) as out:
        yield lambda content: write_private(out / options.output.name, content)


def _read_by(options: argparse.Namespace) -> tuple[Path, ...]:
    """The files that the options name, all but the output: of a fit and of a rig as a whole."""
    found: list[Path] = []
    for name, value in vars(options).items():
        given = value if isinstance(value, list) else [value]
        for path in (each for each in given if isinstance(each, Path) and name != "output"):
            found += [path, *(path / file for file in FIT_FILES if name in FITS)]
            found += [path.with_suffix(".json")] if name == "model" else []
    return tuple(found)
