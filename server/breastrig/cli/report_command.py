"""Measures of one fit, or of two stances of one patient, as JSON, CSV and PDF with a tape sheet of the drawing."""

import argparse
from pathlib import Path

from breastrig.cli.interruption import raise_if_asked
from breastrig.cli.options.output_options import add_language, add_output_options, add_plan_options, say_misfits
from breastrig.use.report import write_report


def add_options(parser: argparse.ArgumentParser) -> None:
    add_plan_options(parser, "shown")
    parser.add_argument(
        "--code",
        default="",
        metavar="CODE",
        help="the patient's code, never a name, on every page and in the PDF's name; by default that of the fit",
    )
    add_language(parser)
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
        language=options.language,
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
