"""What `breastrig export` does; its words stand in export_options.py."""

import argparse
from pathlib import Path

from breastrig.cli.output_options import files_of_fit, files_of_model, output_folder
from breastrig.core.output_files import OutputSet, all_or_nothing
from breastrig.report.files.exported import SET_FORMAT
from breastrig.workflow.export_fit import EXPORT_FILES, EXPORT_RECORD, write_export
from breastrig.workflow.lines.transfer import drawing_document


def run(options: argparse.Namespace) -> int:
    """Writes the files; returns 0."""
    inputs = [options.plan, *files_of_fit(options.fit), *files_of_fit(options.other), *files_of_model(options.model)]
    with all_or_nothing(
        output_folder(options, [OutputSet(Path(), EXPORT_FILES, EXPORT_RECORD, SET_FORMAT)], inputs)
    ) as out:
        plan = None if options.plan is None else drawing_document(options.plan)
        write_export(options.fit, out, options.model, plan, options.other)
    return 0
