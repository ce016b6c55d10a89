"""`breastrig fit SCAN -o OUT`: one scan in, one folder of results out.

With `--with SCAN_B` two stances of one patient are fitted together, their bodies held alike: OUT/first and
OUT/second are the two folders, OUT/pair.json says what they have in common.

Exit codes: 0 done, 1 the fit failed, 2 bad input or usage, 3 written, but not usable.
"""

import argparse
from datetime import date
from pathlib import Path

from breastrig.cli.commands import COMMANDS
from breastrig.cli.output_options import add_output_options
from breastrig.cli.pattern_words import PATTERN_WORDS
from breastrig.core.stances import STANCES
from breastrig.core.units import METRES_PER_UNIT
from breastrig.workflow.jobs import FIRST


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("fit", help=COMMANDS["fit"], description=__doc__)
    parser.add_argument(
        "scan",
        type=Path,
        metavar="SCAN",
        help="PLY, OBJ, STL, GLB, USDZ, points as PCD, XYZ or PLY, or a zip of one with its images",
    )
    parser.add_argument("--landmarks", type=Path, metavar="FILE", help="picked points: JSON, CSV, .pp or .mrk.json")
    parser.add_argument("--units", default="auto", choices=["auto", *METRES_PER_UNIT], help="unit of the scan")
    parser.add_argument(
        "--cuts", type=Path, metavar="FILE", help="what was cut away in the page: the answer of GET /api/scans/ID/cuts"
    )
    parser.add_argument("--stance", default="auto", choices=STANCES, help="stance of the scan")
    parser.add_argument("--with", dest="other", type=Path, metavar="SCAN_B", help="the same patient in another stance")
    parser.add_argument("--with-landmarks", type=Path, metavar="FILE", help="picked points on SCAN_B")
    parser.add_argument("--with-cuts", type=Path, metavar="FILE", help="what was cut away from SCAN_B")
    parser.add_argument("--with-units", default="auto", choices=["auto", *METRES_PER_UNIT], help="unit of SCAN_B")
    parser.add_argument("--with-stance", default="auto", choices=STANCES, help="stance of SCAN_B")
    parser.add_argument(
        "--alike",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="with SCAN_B: bodies held alike, as chests flatten; --no-alike: one body",
    )
    parser.add_argument("--preset", default="default", metavar="NAME", help="default, paper, or a TOML file")
    parser.add_argument("--model", type=Path, metavar="GLB", help="another rig of the same form")
    parser.add_argument(
        "--drawing",
        default=FIRST,
        metavar="NAME",
        help="a drawing of the model (lumpectomy, anatomy, mastectomy; if not said its first: lumpectomy), a pattern "
        "drawn to the patient's measures (reduction:areola_mm=42,limb_mm=50), several joined by +, or none. "
        + PATTERN_WORDS,
    )
    parser.add_argument(
        "--tumour",
        action="append",
        default=[],
        metavar="SIDE:HOUR,DISTANCE,RADIUS",
        help="adds a tumour's circle, may be given again: L:10,45,12 is the left breast at 10 o'clock (as read by an "
        "observer who faces her), 45 mm from the nipple along the skin, radius 12 mm; or at:X,Y,Z,RADIUS, all in mm, "
        "around a place picked in the scan's frame",
    )
    parser.add_argument(
        "--refine",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="a smooth free-form layer follows the skin that the scan shows; --no-refine: the model alone",
    )
    parser.add_argument(
        "--code", default="", metavar="CODE", help="the patient's code, never a name; by default a random one"
    )
    parser.add_argument(
        "--scanned", type=date.fromisoformat, metavar="DATE", help="day of SCAN, as 2026-11-25; stands in reports"
    )
    parser.add_argument("--with-scanned", type=date.fromisoformat, metavar="DATE", help="day of SCAN_B")
    parser.add_argument("--no-progress", action="store_true", help="no progress bar")
    add_output_options(parser, "OUT", "folder for the results")
