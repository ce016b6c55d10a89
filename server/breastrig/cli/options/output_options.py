"""Options of every command that writes results: -o, --force, and the files that are never overwritten."""

import argparse
import sys
from collections.abc import Iterable
from pathlib import Path

from breastrig.cli.interruption import raise_if_asked
from breastrig.core.assets import model_path
from breastrig.core.output_files import Output, OutputSet, single_file
from breastrig.files.result import FIT_FILES
from breastrig.languages.catalogue import ENGLISH, LANGUAGES

MISFIT = 4  # exit code: all is written, but a pattern or an item does not fit on this patient


def say_misfits(reasons: Iterable[str]) -> int:
    """Prints on stderr each item that is not drawn, with the reason; returns the exit code, 0 where there is none."""
    said = tuple(reasons)
    for reason in said:
        print(f"breastrig: {reason}", file=sys.stderr)
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
    parser.add_argument("--model", type=model_path, metavar="MODEL", help="the rig that the fits were made with")
    add_same_patient(parser)


def add_same_patient(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--same-patient",
        action="store_true",
        help="all is one patient's: a plan or drawing whose file names another, or scans that do not look like one's",
    )


def add_language(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--language", choices=LANGUAGES, default=ENGLISH, help="of the pages (default en)")


def output_folder(options: argparse.Namespace, sets: Iterable[OutputSet], inputs: Iterable[Path | None]) -> Output:
    """The command's folder for results; `inputs` that were not given are None."""
    return Output(options.output, tuple(sets), _given(inputs), options.force, raise_if_asked)


def output_file(options: argparse.Namespace, inputs: Iterable[Path | None]) -> Output:
    """The command's one file."""
    return single_file(options.output, _given(inputs), options.force, raise_if_asked)


def files_of_fit(folder: Path | None) -> list[Path]:
    """The files of a fit's folder that a command reads and must not overwrite: the fit as a whole."""
    return [] if folder is None else [folder / name for name in FIT_FILES]


def files_of_model(model: Path | None) -> list[Path]:
    """A rig and its side file."""
    return [] if model is None else [model, model.with_suffix(".json")]


def _given(files: Iterable[Path | None]) -> tuple[Path, ...]:
    return tuple(file for file in files if file is not None)
