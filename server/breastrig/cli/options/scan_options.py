"""Options for reading a scan: its unit, and a person's answers about a label map."""

import argparse
from collections.abc import Iterable, Sequence
from pathlib import Path

from breastrig.cli.messages.say import say
from breastrig.core.units import METRES_PER_UNIT
from breastrig.scan.piece import TakenSegment
from breastrig.scan.volumes.answers import VolumeAnswers, checked_answers, segments_of_words
from breastrig.use.scan import Scan, ScanSource, read_coloured


def add_scan_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--units", default="auto", choices=["auto", *METRES_PER_UNIT], help="unit of the scan")
    add_answers(parser)
    parser.add_argument(
        "--series", metavar="SERIES", help="of several in the DICOM files of an MRI: one of those that are named"
    )


def add_answers(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--frame",
        metavar="FRAME",
        help="of a volume (NIfTI, NRRD, MetaImage) that does not say where it lies, or says it twice: sform, "
        "qform, or three letters that say where the voxels' axes grow to (RAS: right, anterior, superior)",
    )
    parser.add_argument(
        "--segment",
        action="append",
        default=[],
        metavar="N=lesion|tissue|unused",
        help="as what a segment of a label map is to be taken, by its number in the file; may be given again",
    )
    parser.add_argument(
        "--same-place",
        choices=["yes", "no"],
        help="whether lesions of another file lie where the image does, though the file does not say so",
    )


def scan_of(options: argparse.Namespace, scan: Path) -> Scan:
    """The scan, read; prints the names of its segments."""
    answers = _answers(options)
    found = read_coloured(
        scan, options.units, answers.without_lesions if getattr(options, "lesions", None) else answers
    )
    say_segments(found.segments)
    return found


def scan_source(options: argparse.Namespace, scan: Path | Scan, lesions: Sequence[Path] = ()) -> ScanSource:
    """The scan with lesions of other files, to be read when it is needed."""
    units = options.units if isinstance(scan, Path) else "auto"  # else it has been read in its own
    return ScanSource(scan, units, _answers(options), lambda read: say_segments(read.segments), lesions)


def _answers(options: argparse.Namespace) -> VolumeAnswers:
    same_place = getattr(options, "same_place", None)  # of commands that take lesions
    return checked_answers(
        options.frame, segments_of_words(options.segment), getattr(options, "series", None), same_place=same_place
    )


def say_segments(segments: Iterable[TakenSegment]) -> None:
    """Prints the names of a label map's segments: they are needed for choosing, and kept nowhere."""
    for each in segments:
        called = f' "{each.label}"' if each.label else ""
        across = "" if each.radius_mm is None else f", {2 * each.radius_mm:.0f} mm across"
        say(f"segment {each.number}{called}: {each.taken_as} ({each.name}{across}). {each.why}")
