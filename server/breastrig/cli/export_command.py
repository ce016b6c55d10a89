"""A fit for other programs: the drawing as lines (GLB, OBJ, PLY), the model as a closed surface (PLY, STL) with its
landmarks, lines, regions and caps as named sets of vertices (JSON)."""

import argparse
from pathlib import Path

from breastrig.cli.messages.say import say
from breastrig.cli.options.output_options import add_output_options, add_plan_options, writing_folder
from breastrig.core.output_files import OutputSet
from breastrig.core.private_files import write_files
from breastrig.drawings.drawing_file import drawing_document
from breastrig.report.files.exported import SET_FORMAT
from breastrig.use.folder.earlier_fits import unchecked
from breastrig.use.reports.export_fit import EXPORT_FILES, EXPORT_RECORD, export_files


def add_options(parser: argparse.ArgumentParser) -> None:
    add_plan_options(parser, "exported")
    parser.add_argument("--slicer", action="store_true", help="also scene.mrb, for 3D Slicer")
    add_output_options(parser, "DIR", "folder for the files")


def run(options: argparse.Namespace) -> int:
    """Writes the files; returns 0."""
    with writing_folder(options, OutputSet(Path(), EXPORT_FILES, EXPORT_RECORD, SET_FORMAT)) as out:
        plan = None if options.plan is None else drawing_document(options.plan)
        files = export_files(options.fit, options.model, plan, options.other, options.same_patient, options.slicer)
        write_files(files, out)
    say(*unchecked([options.fit, options.other]))
    return 0
