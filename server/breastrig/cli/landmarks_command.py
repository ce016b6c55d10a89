"""`breastrig landmarks SCAN -o FILE`: proposes the landmarks that a scan shows, to be checked by a person."""

import argparse
import json
from pathlib import Path

from breastrig.cli.messages.say import say
from breastrig.cli.options.output_options import add_model, add_output_options, writing_file
from breastrig.cli.options.scan_options import add_scan_options, scan_of
from breastrig.scan.landmarks.landmark_files import landmark_file
from breastrig.use.landmarks import propose_landmarks


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scan", type=Path, metavar="SCAN", help="as for breastrig fit")
    add_scan_options(parser)
    add_model(parser, "another rig of the same form")
    add_output_options(parser, "FILE", ".json (with a confidence and a 90 %% radius each), .csv, .pp, .mrk.json")


NO_CONFIDENCE = (
    "This kind of file has no place for confidences, so a fit takes its points as picked by a person: check each of "
    "them first, or write .json."
)


def run(options: argparse.Namespace) -> int:
    """Proposes and writes, in the scan's frame and unit; returns 0."""
    with writing_file(options) as write:
        write(_proposed(options))
    if _kind(options.output) != "json":
        say(NO_CONFIDENCE)
    return 0


def _kind(path: Path) -> str:
    return "mrk.json" if path.name.lower().endswith(".mrk.json") else path.suffix.lower().lstrip(".")


def _proposed(options: argparse.Namespace) -> bytes:
    """The landmark file."""
    scan = scan_of(options, options.scan)
    proposals = propose_landmarks(scan, model=options.model)
    for sentence in sorted(set(proposals.not_proposed.values())):
        names = ", ".join(name for name, why in proposals.not_proposed.items() if why == sentence)
        say(f"not proposed: {names}. {sentence}")
    places = {name: proposal.point for name, proposal in proposals.items()}
    kind = _kind(options.output)
    confidence = {name: proposal.confidence for name, proposal in proposals.items()}
    content = landmark_file(places, kind, scan.unit, confidence=confidence)
    if kind == "json":
        per_unit = 1e3 * scan.metres_per_unit
        errors = {
            name: None if each.error is None else round(per_unit * each.error, 1) for name, each in proposals.items()
        }
        document = json.loads(content) | {"proposed": True, "error_mm": errors}
        reasons = {name: each.reason for name, each in proposals.items() if each.reason}
        document |= {"reason": reasons} if reasons else {}
        document |= {"not_proposed": dict(proposals.not_proposed)} if proposals.not_proposed else {}
        content = (json.dumps(document, indent=1) + "\n").encode()
    return content
