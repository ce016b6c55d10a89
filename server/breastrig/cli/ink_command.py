"""What `breastrig ink` does; its words stand in ink_options.py."""

import argparse
from collections import Counter

from breastrig.cli.output_options import output_file
from breastrig.core.output_files import all_or_nothing, check_output
from breastrig.core.private_files import write_private
from breastrig.interface.ink import find_ink
from breastrig.workflow.folder.fit_files import json_bytes


def run(options: argparse.Namespace) -> int:
    """Finds and writes, in the scan's frame and unit; returns 0, also where there is no ink."""
    output = output_file(options, [options.scan])
    check_output(output)
    ink = find_ink(options.scan, units=options.units)
    with all_or_nothing(output) as out:
        write_private(out / options.output.name, json_bytes(ink.document))
    length = sum(each.length_mm for each in ink.strokes)
    kinds = Counter(each.kind for each in ink.strokes)
    what = ", ".join(f"{count} {kind}" for kind, count in kinds.items())
    print(f"{len(ink.strokes)} strokes, {length:.0f} mm ({what})." if ink.strokes else "No ink on this scan.")
    return 0
