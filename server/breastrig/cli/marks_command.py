"""`breastrig marks --from OUT_A --to OUT_B SCAN_A SCAN_B -o FILE`: marks that the colours of both scans show, in pairs.

OUT_A and OUT_B are folders that `breastrig fit` wrote, SCAN_A and SCAN_B the coloured scans that were fitted.  Nothing
follows what is proposed: look at each pair, and put those that are right under `marks` of both scans' landmark files.
"""

import argparse
from pathlib import Path

from breastrig.cli.options.output_options import add_model, add_output_options, add_same_patient, writing_file
from breastrig.core.documents import json_bytes
from breastrig.files.result import read_result
from breastrig.use.marks.propose_marks import propose_marks


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scan_a", type=Path, metavar="SCAN_A", help="the scan of OUT_A, with its colours")
    parser.add_argument("scan_b", type=Path, metavar="SCAN_B", help="the scan of OUT_B, with its colours")
    parser.add_argument("--from", dest="from_fit", type=Path, required=True, metavar="OUT_A", help="fit of scan A")
    parser.add_argument("--to", dest="to_fit", type=Path, required=True, metavar="OUT_B", help="fit of scan B")
    add_model(parser, "the rig of both fits, when not the package's")
    add_same_patient(parser)
    add_output_options(parser, "FILE", ".json: the marks of each scan as landmark files have them, and their errors")


def run(options: argparse.Namespace) -> int:
    """Finds and writes; returns 0, also where there is no pair."""
    with writing_file(options) as write:
        found = propose_marks(
            options.from_fit,
            options.to_fit,
            options.scan_a,
            options.scan_b,
            same_patient=options.same_patient,
            model=options.model,
        )
        document = {
            "proposed": True,
            "says": found.says,
            "from": {
                "unit": read_result(options.from_fit).scan.unit,
                "marks": {m.name: m.source.tolist() for m in found},
            },
            "to": {"unit": read_result(options.to_fit).scan.unit, "marks": {m.name: m.target.tolist() for m in found}},
            "pairs": {
                m.name: {"kind": m.kind, "off_mm": round(m.off_mm, 1), "error_mm": round(m.error_mm, 1)} for m in found
            },
        }
        write(json_bytes(document))
    print(found.says)
    return 0
