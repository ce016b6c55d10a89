"""`breastrig transfer --from OUT_A --to OUT_B -o FILE`: a drawing made on scan A, shown on scan B.

OUT_A and OUT_B are folders that `breastrig fit` wrote.  The drawing lies on scan A (points in its frame) or on the
model (surface_points), or is a whole plan (breastrig/plan@1); without --drawing it is the one that the fit of scan A
left.  FILE is in scan B's frame and unit and says of each point how far off its place may be.
"""

import argparse
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from breastrig.cli.messages.say import say
from breastrig.cli.options.output_options import (
    add_model,
    add_output_options,
    add_same_patient,
    say_misfits,
    writing_file,
)
from breastrig.core.documents import json_bytes
from breastrig.files.result import read_result
from breastrig.scan.landmarks.marks import listed
from breastrig.use.folder.earlier_fits import unchecked
from breastrig.use.transfer import transfer


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--from", dest="from_fit", type=Path, required=True, metavar="OUT_A", help="fit of scan A")
    parser.add_argument("--to", dest="to_fit", type=Path, required=True, metavar="OUT_B", help="fit of scan B")
    parser.add_argument("--drawing", type=Path, metavar="FILE", help="a drawing on scan A or on the model, or a plan")
    parser.add_argument(
        "--other-patient", action="store_true", help="the scans are of two patients: same place instead of same skin"
    )
    add_model(parser, "the rig of both fits, when not the package's")
    add_same_patient(parser)
    add_output_options(parser, "FILE", "drawing on scan B, JSON")


def run(options: argparse.Namespace) -> int:
    """Transfers and writes; returns 0, or 4 where an item does not fit on scan B."""
    with writing_file(options) as write:
        drawing = transfer(
            options.from_fit,
            options.to_fit,
            options.drawing,
            other_patient=options.other_patient,
            same_patient=options.same_patient,
            model=options.model,
        )
        write(json_bytes(drawing.document))
    document = drawing.document
    say(*document.get("doubts", ()), *document.get("moved", ()), *_of_marks(document))
    scale = None if options.drawing is None else read_result(options.from_fit).scale
    if scale is not None:
        say(
            f"The scan of --from was scaled by {scale.factor:.3f} to its true size; the places of --drawing "
            "were taken to be in that size, not in that of the scan's file.",
        )
    say(*unchecked([options.from_fit, options.to_fit]))
    shapes = document["shapes"]
    bridged, count = sum(sum(shape["bridged"]) for shape in shapes), sum(len(shape["points"]) for shape in shapes)
    if sys.stdout.isatty():
        print(f"{count} points, {bridged} of them over holes of the scan; drawing in {options.output}")
    return say_misfits([str(each["reason"]) for each in document.get("missing", ())])


def _of_marks(document: Mapping[str, Any]) -> Iterator[str]:
    """A sentence for each mark that is asked about, and what was followed."""
    marks = document.get("marks")
    if marks is None:
        return
    yield from (each["says"] for each in marks["asked"])
    if marks["followed"]:
        yield f"Marks followed: {listed(marks['followed'])}."
    if marks["unpaired"]:
        yield f"Marks on one of the scans only, not followed: {listed(marks['unpaired'])}."
