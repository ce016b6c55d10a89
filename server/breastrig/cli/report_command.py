"""Measures of one fit, or of two stances of one patient, as JSON, CSV and two pages of PDF."""

import argparse
from pathlib import Path

from threadpoolctl import threadpool_limits

from breastrig.cli.output_options import add_output_options, files_of_fit, files_of_model, output_folder
from breastrig.core.output_record import OutputSet
from breastrig.core.staged_output import all_or_nothing
from breastrig.report.document import SCHEMA
from breastrig.workflow.report import REPORT_FILES, REPORT_RECORD, ReportJob, write_report


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("report", help="measures and pictures of one or two fits", description=__doc__)
    parser.add_argument(
        "fit", type=Path, metavar="OUT", help="folder that `breastrig fit` wrote, with or without --with"
    )
    parser.add_argument(
        "--with", dest="other", type=Path, metavar="OUT_B", help="fit of the same patient in another stance"
    )
    parser.add_argument("--model", type=Path, metavar="GLB", help="the rig that the fits were made with")
    add_output_options(parser, "DIR", "folder for the three files")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Writes report.json, measures.csv and report.pdf; returns 0."""
    fit, other = _stances(options)
    inputs = [*files_of_fit(fit), *files_of_fit(other), *files_of_model(options.model)]
    files = OutputSet(Path(), REPORT_FILES, REPORT_RECORD, SCHEMA)
    with threadpool_limits(1), all_or_nothing(output_folder(options, [files], inputs)) as out:
        write_report(ReportJob(fit, other, options.model), out)
    return 0


def _stances(options: argparse.Namespace) -> tuple[Path, Path | None]:
    """The folder or folders of the fits; a fit of two stances together left both in one."""
    fit: Path = options.fit
    if options.other is None and (fit / "pair.json").is_file():
        return fit / "first", fit / "second"
    return fit, options.other
