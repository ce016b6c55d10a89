"""`breastrig landmarks SCAN -o FILE`: proposes all landmarks of the model on a scan, to be checked by a person."""

import argparse
import json
from pathlib import Path

from threadpoolctl import threadpool_limits

from breastrig.core.errors import BadInput, BadScan
from breastrig.core.units import METRES_PER_UNIT
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.jobs.propose_on_scan import propose_on_scan
from breastrig.scan.landmark_files import landmark_file
from breastrig.scan.read import read_scan


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("landmarks", help="propose the landmarks on one scan", description=__doc__)
    parser.add_argument("scan", type=Path, metavar="SCAN")
    parser.add_argument("--units", default="auto", choices=["auto", *METRES_PER_UNIT], help="unit of the scan")
    parser.add_argument("--model", type=Path, metavar="GLB", help="another rig of the same form")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="FILE",
        help=".json (with confidences), .csv, .pp, .mrk.json",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Proposes and writes, in the scan's frame and unit; returns 0."""
    if not options.scan.is_file():
        raise BadScan(f"There is no scan file {options.scan}; check the name.")
    scan = read_scan(options.scan, None, options.units, texture=False)
    rig = read_rig(options.model or default_rig_path())
    with threadpool_limits(1):
        proposals = propose_on_scan(rig, scan)
    places = {name: p.point / scan.metres_per_unit for name, p in proposals.items()}
    name = options.output.name.lower()
    kind = "mrk.json" if name.endswith(".mrk.json") else options.output.suffix.lower().lstrip(".")
    content = landmark_file(places, kind, scan.unit)
    if kind == "json":
        confidence = {name: proposal.confidence for name, proposal in proposals.items()}
        document = json.loads(content) | {"proposed": True, "confidence": confidence}
        content = (json.dumps(document, indent=1) + "\n").encode()
    try:
        options.output.parent.mkdir(parents=True, exist_ok=True)
        options.output.write_bytes(content)
    except OSError as error:
        raise BadInput(f"{options.output} cannot be written ({error.strerror}); choose another file.") from error
    return 0
