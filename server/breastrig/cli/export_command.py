"""A fit for other programs: the drawing as lines (GLB, OBJ, PLY), the model as a closed surface (PLY, STL) with its
landmarks, lines, regions and caps as named sets of vertices (JSON)."""

import argparse
from pathlib import Path

from breastrig.jobs.export_fit import write_export


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("export", help="drawing and closed surface for other programs", description=__doc__)
    parser.add_argument("fit", type=Path, metavar="OUT", help="folder that `breastrig fit` wrote")
    parser.add_argument("--model", type=Path, metavar="GLB", help="the rig that the fit was made with")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="folder for the files")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Writes the files; returns 0."""
    write_export(options.fit, options.output, options.model)
    return 0
