"""A template in true size of one fit's planned lines: the skin around them laid flat on A4 sheets, to print, cut out
and lay on notch and nipple.  Says of each line how far off it is on the paper.  Or a guide (STL) to print in 3D."""

import argparse

from breastrig.cli.interruption import raise_if_asked
from breastrig.cli.options.output_options import add_language, add_output_options, add_plan_options
from breastrig.use.guides.write_template import write_template


def add_options(parser: argparse.ArgumentParser) -> None:
    add_plan_options(parser, "shown")
    parser.add_argument(
        "--code", default="", metavar="CODE", help="the patient's code, never a name; by default that of the fit"
    )
    parser.add_argument("--side", choices=("L", "R"), default="", help="of a guide: the patient's left or right")
    add_language(parser)
    add_output_options(parser, "FILE", "template.pdf, or guide.stl of one side")


def run(options: argparse.Namespace) -> int:
    """Writes the file, and says how far a guide's arrow is from the notch; returns 0."""
    said = write_template(
        options.fit,
        options.output,
        options.other,
        plan=options.plan,
        side=options.side,
        code=options.code,
        same_patient=options.same_patient,
        language=options.language,
        force=options.force,
        model=options.model,
        asked_to_stop=raise_if_asked,
    )
    print(said, end="\n" if said else "")
    return 0
