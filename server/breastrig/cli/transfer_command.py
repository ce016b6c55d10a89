"""What `breastrig transfer` does; its words stand in transfer_options.py."""

import argparse
import sys

from breastrig.cli.output_options import files_of_fit, files_of_model, output_file
from breastrig.core.output_files import all_or_nothing
from breastrig.interface.transfer import transfer


def run(options: argparse.Namespace) -> int:
    """Carries and writes; returns 0."""
    fits = [*files_of_fit(options.from_fit), *files_of_fit(options.to_fit)]
    inputs = [options.drawing, *fits, *files_of_model(options.model)]
    with all_or_nothing(output_file(options, inputs)) as out:
        drawing = transfer(
            options.from_fit,
            options.to_fit,
            options.drawing,
            other_patient=options.other_patient,
            model=options.model,
        )
        drawing.save(out / options.output.name)
    shapes = drawing.document["shapes"]
    bridged, count = sum(sum(shape["bridged"]) for shape in shapes), sum(len(shape["points"]) for shape in shapes)
    if sys.stdout.isatty():
        print(f"{count} points, {bridged} of them over holes of the scan; drawing in {options.output}")
    return 0
