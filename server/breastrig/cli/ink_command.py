"""`breastrig ink SCAN -o FILE`: finds lines that were drawn with a marker on the skin, in the scan's colours."""

import argparse
from collections import Counter
from pathlib import Path

from breastrig.cli.options.output_options import add_output_options, writing_file
from breastrig.core.documents import json_bytes
from breastrig.core.units import METRES_PER_UNIT
from breastrig.use.ink import find_ink


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scan", type=Path, metavar="SCAN", help="as for breastrig fit; with its colours")
    parser.add_argument("--units", default="auto", choices=["auto", *METRES_PER_UNIT], help="unit of the scan")
    add_output_options(parser, "FILE", ".json, a drawing; each shape says its kind, marker and length")


def run(options: argparse.Namespace) -> int:
    """Finds and writes, in the scan's frame and unit; returns 0, also where there is no ink."""
    with writing_file(options) as write:
        ink = find_ink(options.scan, units=options.units)
        write(json_bytes(ink.document))
    length = sum(each.length_mm for each in ink.strokes)
    kinds = Counter(each.kind for each in ink.strokes)
    what = ", ".join(f"{count} {kind}" for kind, count in kinds.items())
    print(f"{len(ink.strokes)} strokes, {length:.0f} mm ({what})." if ink.strokes else "No ink on this scan.")
    return 0
