"""Measures of one fit, or of two stances of one patient, as JSON, CSV and PDF with a tape sheet of the drawing."""

import argparse
from pathlib import Path

from breastrig.cli.interruption import raise_if_asked
from breastrig.cli.output_options import add_output_options, add_same_patient, say_misfits
from breastrig.core.assets import model_path
from breastrig.use.report import write_report


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "fit", type=Path, metavar="OUT", help="folder that `breastrig fit` wrote, with or without --with"
    )
    parser.add_argument(
        "--with", dest="other", type=Path, metavar="OUT_B", help="fit of the same patient in another stance"
    )
    parser.add_argument(
        "--plan", type=Path, metavar="FILE", help="plan or drawing that is shown instead of the fit's own drawing"
    )
    parser.add_argument(
        "--code",
        default="",
        metavar="CODE",
        help="the patient's code, never a name, on every page and in the PDF's name; by default that of the fit",
    )
    parser.add_argument("--model", type=model_path, metavar="MODEL", help="the rig that the fits were made with")
    add_same_patient(parser)
    add_output_options(parser, "DIR", "folder for the three files")


def run(options: argparse.Namespace) -> int:
    """Writes report.json, measures.csv and the PDF; returns 0, or 4 where something is not drawn."""
    fit, other = _stances(options)
    missing = write_report(
        fit,
        options.output,
        other,
        plan=options.plan,
        code=options.code,
        same_patient=options.same_patient,
        force=options.force,
        model=options.model,
        asked_to_stop=raise_if_asked,
    )
    return say_misfits(missing)


def _stances(options: argparse.Namespace) -> tuple[Path, Path | None]:
    """The folder or folders of the fits; an earlier version's fit of two stances left both in one."""
    fit: Path = options.fit
    if options.other is None and (fit / "pair.json").is_file():
        return fit / "first", fit / "second"
    return fit, options.other
