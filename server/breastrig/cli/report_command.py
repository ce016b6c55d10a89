"""What `breastrig report` does; its words stand in report_options.py."""

import argparse
from pathlib import Path

from threadpoolctl import threadpool_limits

from breastrig.cli.output_options import files_of_fit, files_of_model, output_folder
from breastrig.core.output_record import OutputSet
from breastrig.core.staged_output import all_or_nothing
from breastrig.report.document import SCHEMA
from breastrig.workflow.further_jobs import ReportJob
from breastrig.workflow.lines.transfer import drawing_document
from breastrig.workflow.report import REPORT_FILES, REPORT_RECORD, write_report


def run(options: argparse.Namespace) -> int:
    """Writes report.json, measures.csv and report.pdf; returns 0."""
    fit, other = _stances(options)
    inputs = [options.plan, *files_of_fit(fit), *files_of_fit(other), *files_of_model(options.model)]
    files = OutputSet(Path(), REPORT_FILES, REPORT_RECORD, SCHEMA)
    with threadpool_limits(1), all_or_nothing(output_folder(options, [files], inputs)) as out:
        plan = None if options.plan is None else drawing_document(options.plan)
        write_report(ReportJob(fit, other, options.model, plan=plan), out)
    return 0


def _stances(options: argparse.Namespace) -> tuple[Path, Path | None]:
    """The folder or folders of the fits; a fit of two stances together left both in one."""
    fit: Path = options.fit
    if options.other is None and (fit / "pair.json").is_file():
        return fit / "first", fit / "second"
    return fit, options.other
