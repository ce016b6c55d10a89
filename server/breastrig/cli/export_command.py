"""A fit for other programs: the drawing as lines (GLB, OBJ, PLY), the model as a closed surface (PLY, STL) with its
landmarks, lines, regions and caps as named sets of vertices (JSON)."""

import argparse
from pathlib import Path

from breastrig.cli.output_options import add_output_options, files_of_fit, files_of_model, output_folder
from breastrig.core.output_record import OutputSet
from breastrig.core.staged_output import all_or_nothing
from breastrig.report.exported import SET_FORMAT
from breastrig.workflow.export_fit import EXPORT_FILES, EXPORT_RECORD, write_export


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("export", help="drawing and closed surface for other programs", description=__doc__)
    parser.add_argument("fit", type=Path, metavar="OUT", help="folder that `breastrig fit` wrote")
    parser.add_argument("--model", type=Path, metavar="GLB", help="the rig that the fit was made with")
    add_output_options(parser, "DIR", "folder for the files")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Writes the files; returns 0."""
    inputs = [*files_of_fit(options.fit), *files_of_model(options.model)]
    with all_or_nothing(
        output_folder(options, [OutputSet(Path(), EXPORT_FILES, EXPORT_RECORD, SET_FORMAT)], inputs)
    ) as out:
        write_export(options.fit, out, options.model)
    return 0
