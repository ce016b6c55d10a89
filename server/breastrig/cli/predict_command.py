"""`breastrig predict OUT --stance supine -o PREDICTED`: the patient of a fit in a stance that was not scanned.

PREDICTED gets the files of a fit, marked as predicted; `breastrig transfer --to PREDICTED` shows drawings on it.
"""

import argparse
import sys
from pathlib import Path
from typing import get_args

from breastrig.cli.messages.say import say
from breastrig.cli.options.output_options import add_model, add_output_options, say_misfits, writing_folder
from breastrig.core.stances import Stance
from breastrig.files.result import fit_set
from breastrig.report.bands import lines_text
from breastrig.use.folder.earlier_fits import unchecked
from breastrig.use.predict import predict


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fit", type=Path, metavar="OUT", help="folder that `breastrig fit` wrote")
    parser.add_argument("--stance", choices=get_args(Stance), required=True, help="the stance to predict")
    add_model(parser, "the rig of the fit, when not the package's")
    add_output_options(parser, "PREDICTED", "folder for the results")


def run(options: argparse.Namespace) -> int:
    """Predicts and writes; returns 0, or 4 where a pattern does not fit on the predicted body."""
    with writing_folder(options, fit_set(Path())) as out:
        found = predict(options.fit, options.stance, options.model)
        found.write(out)
    say(*unchecked([options.fit]))
    if sys.stdout.isatty():
        said = lines_text(found.line_error_mm, found.drawn_line_error_mm)
        print(f"{found.verdict.reasons[0]}  {said[:1].upper()}{said[1:]}.")
    return say_misfits(found.drawing_missing)
