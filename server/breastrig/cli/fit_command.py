"""`breastrig fit SCAN -o OUT`: one scan in, one folder of results out.

Exit codes: 0 done, 1 the fit failed, 2 bad input or usage, 3 written, but not usable.
"""

import argparse
import sys
from datetime import date
from pathlib import Path

from breastrig.cli.interruption import raise_if_asked
from breastrig.cli.messages.progress import fitted
from breastrig.cli.messages.say import say
from breastrig.cli.options.output_options import MISFIT, add_model, add_output_options, output_folder
from breastrig.cli.options.scan_options import add_scan_options, scan_of, scan_source
from breastrig.core.output_files import Output, all_or_nothing
from breastrig.core.stances import STANCES
from breastrig.drawings.patterns import pattern_help
from breastrig.files.result import ResultFile, fit_set, patient_of
from breastrig.fitting.verdicts.verdict import WITH_MARGIN
from breastrig.report.bands import margin_text, sure_text
from breastrig.report.pages.printable import checked_code
from breastrig.use.fit import FitRun, Iterate, iterates
from breastrig.use.steps.settings import FIRST
from breastrig.use.values.fit_result import Fit


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "scan",
        type=Path,
        metavar="SCAN",
        help="PLY, OBJ, STL, GLB, USDZ, points as PCD, XYZ or PLY, a label map (NIfTI, NRRD, MHA, DICOM SEG), an "
        "MRI (DICOM: folder or zip), or a zip of one with its images",
    )
    parser.add_argument("--landmarks", type=Path, metavar="FILE", help="picked points: JSON, CSV, .pp or .mrk.json")
    parser.add_argument(
        "--length",
        nargs=3,
        metavar=("A", "B", "MM"),
        help="straight way in mm between two landmarks or marks, as measured on the patient: scales the scan to it",
    )
    add_scan_options(parser)
    parser.add_argument(
        "--lesions",
        type=Path,
        nargs="+",
        action="extend",
        default=[],
        metavar="FILE",
        help="lesions drawn on the image that SCAN is: NIfTI, NRRD, DICOM SEG or RTSTRUCT; --frame and --segment are "
        "then of these files, too",
    )
    parser.add_argument(
        "--cuts", type=Path, metavar="FILE", help="parts cut away in the page: the answer of GET /api/scans/ID/cuts"
    )
    parser.add_argument("--stance", default="auto", choices=STANCES, help="stance of the scan")
    parser.add_argument("--preset", default="default", metavar="NAME", help="default, paper, or a TOML file")
    add_model(parser, "another rig of the same form")
    parser.add_argument(
        "--prior", type=Path, metavar="FILE", help="a prior from a cohort's fits, by `breastrig cohort`"
    )
    parser.add_argument(
        "--drawing",
        default=FIRST,
        metavar="NAME",
        help="a drawing of the model (lumpectomy, anatomy, mastectomy; if not said its first: lumpectomy), a pattern "
        "drawn to the patient's measures (reduction:areola_mm=42,limb_mm=50), several joined by +, or none. "
        + pattern_help(),
    )
    parser.add_argument(
        "--tumour",
        action="append",
        default=[],
        metavar="SIDE:HOUR,DISTANCE,RADIUS",
        help="adds a tumour's circle, may be given again: L:10,45,12 is the left breast at 10 o'clock (as read by an "
        "observer facing the patient), 45 mm from the nipple along the skin, radius 12 mm; or at:X,Y,Z,RADIUS, "
        "all in mm, around a place picked in the scan's frame",
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
        "--scanned", type=date.fromisoformat, metavar="DATE", help="day of SCAN, as 2026-11-25; shown in reports"
    )
    parser.add_argument("--no-progress", action="store_true", help="no progress bar")
    add_output_options(parser, "OUT", "folder for the results")


UNUSABLE = 3  # exit code
SAID = {
    "good": "a good fit",
    "uncalibrated": "not calibrated for this rig",
    "check": "a fit to check",
    "unusable": "not usable",
}
LEVELS = {
    "good": "",
    "uncalibrated": "no verdict: ",
    "check": "check this fit: ",
    "unusable": "this fit is not usable: ",
}


def _output(options: argparse.Namespace) -> Output:
    """The output folder with its files, and the input files."""
    preset = [Path(options.preset)] if options.preset.endswith(".toml") else []
    return output_folder(options, fit_set(Path()), also_read=preset)


def _run(options: argparse.Namespace) -> FitRun[Iterate, Fit]:
    """The fit, ready for the first iteration."""
    cut = None if options.cuts is None else scan_of(options, options.scan).without(options.cuts)
    return iterates(
        scan_source(options, cut or options.scan, options.lesions),
        options.landmarks,
        length=options.length,
        stance=options.stance,
        preset=options.preset,
        drawing=None if options.drawing == "none" else options.drawing,
        tumours=options.tumour,
        refine=options.refine,
        model=options.model,
        prior=options.prior,
    )


def _to_check(reason: str) -> str:
    """The message on a pick that was followed: a question, or a sentence with what to do."""
    return reason if reason.endswith("?") else f"{reason.removesuffix('.')}; check it."


def run(options: argparse.Namespace) -> int:
    """Fits and writes; returns 0, 3 where the result cannot be used, or 4 where a pattern does not fit."""
    patient = patient_of(checked_code(options.code), options.scanned)
    with all_or_nothing(_output(options)) as out:
        fit = fitted(_run(options), options.no_progress)
        raise_if_asked()
        fit.write(out, patient)
    result, verdict = fit.in_metres.result, fit.verdict
    said = [
        *result.notes,
        *((result.stance_reason,) if result.stance_asked else ()),
        *(f"{LEVELS[verdict.level]}{reason}" for reason in verdict.reasons),
        *(sure_text(result, result.drawn_line_error_mm) for reason in verdict.reasons if WITH_MARGIN in reason),
        *(pick.reason for pick in result.landmarks_not_followed),
        *(_to_check(pick.reason) for pick in result.landmarks_unusual),
        *(mark.reason for mark in result.marks_asked),
        *result.drawing_missing,
        *_worth_a_check(fit),
    ]
    say(*said)
    if sys.stdout.isatty():
        print(f"{summary(result)}; patient {patient.code}, results in {options.output}")
    if verdict.level == "unusable":
        return UNUSABLE
    return MISFIT if fit.drawing_missing else 0


def _worth_a_check(fit: Fit) -> tuple[str, ...]:
    """A sentence on the landmarks that would make lines surer by a finger; empty where none would."""
    found = fit.checks()
    if not found.worth_it:
        return ()
    *first, last = (f"the {each.label}" for each in found.checks)
    which = f"{', '.join(first)} and {last}" if first else last
    now, then = margin_text(found.line_error_mm), margin_text(found.expected_line_error_mm)
    return (f"With {which} placed by hand lines would be sure to about {then} instead of {now}.",)


def _mm(distance: float | None) -> str:
    """The distance as text; it is None where the scan shows no skin near the model."""
    return "no distance" if distance is None else f"{distance:.2f} mm"


def summary(result: ResultFile) -> str:
    """A result.json in one line: first the errors of lines and landmarks, then distances to the skin."""
    level = result.verdict.level if result.verdict else "check"
    sure = "" if level == "unusable" else sure_text(result, result.drawn_line_error_mm)
    found, alone = (_mm(each.surface_distance_mm.mean) for each in (result, result.distances))
    to_scan = f"{found} to the scan" + (f" (the model alone {alone})" if result.refined else "")
    picks = result.landmark_distance_mm.mean
    to_picks = "" if picks is None else f", {picks:.2f} mm to the landmarks"
    return f"{SAID[level]}{sure and f': {sure}'}; {to_scan}{to_picks}"
