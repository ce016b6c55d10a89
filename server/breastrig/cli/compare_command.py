"""`breastrig compare --on OUT FIRST SECOND -o DIR`: two drawings on one scan, superimposed.

For instance the surgeon's own drawing (shown black) and the model's (shown white), or one drawn lying and one that was
carried there.  DIR gets compare.png, compare.csv and compare.json: for each shape that both have the distance in mm,
both ways: mean, 95 % and largest.
"""

import argparse
import sys
from pathlib import Path

from breastrig.cli.messages.say import say
from breastrig.cli.options.output_options import add_model, add_output_options, add_same_patient, writing_folder
from breastrig.core.output_files import OutputSet
from breastrig.use.folder.earlier_fits import unchecked
from breastrig.use.lines.compare import COMPARE_FILES, COMPARE_RECORD, SCHEMA, CompareJob, compare


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("first", type=Path, metavar="FIRST", help="a drawing on the scan, or on the model; black")
    parser.add_argument("second", type=Path, metavar="SECOND", help="another one; white")
    parser.add_argument("--on", dest="fit", type=Path, required=True, metavar="OUT", help="the scan's fit")
    add_model(parser, "the rig of the fit, when not the package's")
    add_same_patient(parser)
    add_output_options(parser, "DIR", "folder for the results")


def run(options: argparse.Namespace) -> int:
    """Measures, draws and writes; returns 0."""
    with writing_folder(options, OutputSet(Path(), COMPARE_FILES, COMPARE_RECORD, SCHEMA)) as out:
        document = compare(
            CompareJob(options.fit, options.first, options.second, out, options.model, options.same_patient)
        )
    say(*unchecked([options.fit]))
    if sys.stdout.isatty():
        for row in document["distances"]:
            print(f"{row['shape']}: mean {row['mean_mm']:.2f}, 95 % {row['p95_mm']:.2f}, max {row['max_mm']:.2f} mm")
    return 0
