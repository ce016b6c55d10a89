"""`breastrig transfer --from OUT_A --to OUT_B -o FILE`: a drawing made on scan A, shown on scan B.

OUT_A and OUT_B are folders that `breastrig fit` wrote.  The drawing lies on scan A (points in its frame) or on the
model (surface_points); without --drawing it is the one that the fit of scan A left.  FILE is in scan B's frame and
unit and says of each point how far the fits were from their scans there.
"""

import argparse
import sys
from pathlib import Path

from threadpoolctl import threadpool_limits

from breastrig.cli.output_options import add_output_options, files_of_fit, files_of_model, output_file
from breastrig.core.private_files import write_private
from breastrig.core.staged_output import all_or_nothing
from breastrig.workflow.fit_files import json_bytes
from breastrig.workflow.transfer import TransferJob, drawing_document, transfer


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("transfer", help="show a drawing of one scan on another", description=__doc__)
    parser.add_argument("--from", dest="from_fit", type=Path, required=True, metavar="OUT_A", help="fit of scan A")
    parser.add_argument("--to", dest="to_fit", type=Path, required=True, metavar="OUT_B", help="fit of scan B")
    parser.add_argument("--drawing", type=Path, metavar="FILE", help="a drawing on scan A or on the model")
    parser.add_argument(
        "--other-patient", action="store_true", help="the scans are of two patients: same place instead of same skin"
    )
    parser.add_argument("--model", type=Path, metavar="GLB", help="the rig of both fits, when not the package's")
    add_output_options(parser, "FILE", "drawing on scan B, JSON")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Carries and writes; returns 0."""
    fits = [*files_of_fit(options.from_fit), *files_of_fit(options.to_fit)]
    inputs = [options.drawing, *fits, *files_of_model(options.model)]
    with threadpool_limits(1), all_or_nothing(output_file(options, inputs)) as out:
        drawing = None if options.drawing is None else drawing_document(options.drawing)
        document = transfer(
            TransferJob(options.from_fit, options.to_fit, drawing, options.other_patient, options.model)
        )
        write_private(out / options.output.name, json_bytes(document))
    bridged = sum(sum(shape["bridged"]) for shape in document["shapes"])
    count = sum(len(shape["points"]) for shape in document["shapes"])
    if sys.stdout.isatty():
        print(f"{count} points, {bridged} of them over holes of the scan; drawing in {options.output}")
    return 0
