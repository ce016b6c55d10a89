"""Options for reading a scan: its unit, and a person's answers about a label map."""

import argparse
import sys
from pathlib import Path

from breastrig.core.units import METRES_PER_UNIT
from breastrig.scan.scan import Scan as ScanInMetres
from breastrig.scan.volumes.answers import VolumeAnswers, checked_answers, segments_of_words
from breastrig.use.scan import Scan, ScanSource, read_coloured


def add_scan_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--units", default="auto", choices=["auto", *METRES_PER_UNIT], help="unit of the scan")
    parser.add_argument(
        "--frame",
        metavar="FRAME",
        help="of a NIfTI label map that does not say where it lies, or says it twice: sform, qform, or three letters "
        "that say where the voxels' axes grow to (RAS: right, anterior, superior)",
    )
    parser.add_argument(
        "--segment",
        action="append",
        default=[],
        metavar="N=lesion|tissue|unused",
        help="as what a segment of a label map is to be taken, by its number in the file; may be given again",
    )


def scan_of(options: argparse.Namespace, scan: Path) -> Scan:
    """The scan, read; prints the names of its segments."""
    found = read_coloured(scan, options.units, _answers(options))
    say_segments(found.in_metres)
    return found


def scan_source(options: argparse.Namespace, scan: Path) -> ScanSource:
    """The scan, to be read when it is needed."""
    return ScanSource(scan, options.units, _answers(options), say_segments)


def _answers(options: argparse.Namespace) -> VolumeAnswers:
    return checked_answers(options.frame, segments_of_words(options.segment))


def say_segments(scan: ScanInMetres) -> None:
    """Prints the names of a label map's segments: they are needed for choosing, and kept nowhere."""
    for each in scan.segments:
        called = f' "{each.label}"' if each.label else ""
        across = "" if each.radius_mm is None else f", {2 * each.radius_mm:.0f} mm across"
        print(
            f"breastrig: segment {each.number}{called}: {each.taken_as} ({each.name}{across}). {each.why}",
            file=sys.stderr,
        )
