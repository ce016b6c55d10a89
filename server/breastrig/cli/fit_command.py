"""`breastrig fit SCAN -o OUT`: one scan in, one folder of results out.

With `--with SCAN_B` two stances of one patient are fitted together, their bodies held alike: OUT/first and
OUT/second are the two folders, OUT/pair.json says what they have in common.

Exit codes: 0 done, 1 the fit failed, 2 bad input or usage, 3 written, but not usable.
"""

import argparse
import sys
from datetime import date
from pathlib import Path

from tqdm import tqdm

from breastrig.cli.interruption import raise_if_asked
from breastrig.cli.output_options import MISFIT, add_output_options, files_of_model, output_folder
from breastrig.cli.scan_options import add_scan_options, scan_of, scan_source
from breastrig.core.assets import model_path
from breastrig.core.errors import BadSettings
from breastrig.core.output_files import Output, all_or_nothing
from breastrig.core.stances import STANCES
from breastrig.core.units import METRES_PER_UNIT
from breastrig.drawings.patterns import pattern_help
from breastrig.files.result import ResultFile, fit_set, write_patient
from breastrig.interface.fit_result import Fit
from breastrig.interface.pair import PAIR_SETS, FitPair, pair_iterates
from breastrig.interface.run import FitRun, Iterate, iterates
from breastrig.interface.scan import Scan, read_coloured
from breastrig.report.bands import sure_text
from breastrig.report.pages.printable import checked_code
from breastrig.workflow.jobs import FIRST


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "scan",
        type=Path,
        metavar="SCAN",
        help="PLY, OBJ, STL, GLB, USDZ, points as PCD, XYZ or PLY, a label map (NIfTI, DICOM SEG), or a zip of one "
        "with its images",
    )
    parser.add_argument("--landmarks", type=Path, metavar="FILE", help="picked points: JSON, CSV, .pp or .mrk.json")
    add_scan_options(parser)
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
    parser.add_argument("--model", type=model_path, metavar="MODEL", help="another rig of the same form")
    parser.add_argument(
        "--prior", type=Path, metavar="FILE", help="what a cohort's fits say of bodies: `breastrig cohort`"
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
        "--scanned", type=date.fromisoformat, metavar="DATE", help="day of SCAN, as 2026-11-25; shown in reports"
    )
    parser.add_argument("--with-scanned", type=date.fromisoformat, metavar="DATE", help="day of SCAN_B")
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
    """What will be written, and what is read."""
    preset = Path(options.preset) if options.preset.endswith(".toml") else None
    first = options.scan, options.landmarks, options.cuts
    second = options.other, options.with_landmarks, options.with_cuts
    inputs = [*first, *second, preset, options.prior]
    sets = [fit_set(Path())] if options.other is None else PAIR_SETS
    return output_folder(options, sets, [*inputs, *files_of_model(options.model)])


def _scan(file: Path, units: str, cuts: Path | None) -> tuple[Scan | Path, str]:
    """The scan as a fit is given it, and the unit that is still to be said with it."""
    return (file, units) if cuts is None else (read_coloured(file, units).without(cuts), "auto")


def _run(options: argparse.Namespace) -> FitRun[Iterate, Fit] | FitRun[tuple[Iterate, Iterate], FitPair]:
    """The fit, or the two together, ready for the first iteration."""
    drawing = None if options.drawing == "none" else options.drawing
    if options.other is None:
        cut = None if options.cuts is None else scan_of(options, options.scan).without(options.cuts)
        return iterates(
            cut or scan_source(options, options.scan),
            options.landmarks,
            stance=options.stance,
            preset=options.preset,
            drawing=drawing,
            tumours=options.tumour,
            refine=options.refine,
            model=options.model,
            prior=options.prior,
        )
    scan, units = _scan(options.scan, options.units, options.cuts)
    other, other_units = _scan(options.other, options.with_units, options.with_cuts)
    return pair_iterates(
        scan,
        other,
        options.landmarks,
        options.with_landmarks,
        units=units,
        second_units=other_units,
        stance=options.stance,
        second_stance=options.with_stance,
        preset=options.preset,
        drawing=drawing,
        tumours=options.tumour,
        refine=options.refine,
        alike=options.alike,
        model=options.model,
        prior=options.prior,
    )


def _to_check(reason: str) -> str:
    """What is said of a pick that was followed, as a question or with what to do."""
    return reason if reason.endswith("?") else f"{reason.removesuffix('.')}; check it."


def run(options: argparse.Namespace) -> int:
    """Fits and writes; returns 0, 3 where that is of no use, or 4 where a pattern does not fit on this patient."""
    files = options.with_landmarks or options.with_cuts
    given = files or not options.alike or (options.with_units, options.with_stance) != ("auto", "auto")
    if options.other is None and given:
        names = "--with-landmarks, --with-cuts, --with-units, --with-stance and --no-alike"
        raise BadSettings(f"{names} need --with SCAN_B.")
    code = checked_code(options.code)
    quiet = options.no_progress or not sys.stderr.isatty()
    with all_or_nothing(_output(options)) as out, tqdm(unit="step", leave=False, disable=quiet) as bar:
        fitting = _run(options)
        bar.reset(fitting.iterations_limit)
        for step in fitting:
            raise_if_asked()
            iterate = step[1] if isinstance(step, tuple) else step
            bar.update(iterate.iteration - bar.n)
            bar.set_postfix_str(f"{iterate.stage}, {iterate.mean_distance_mm:.2f} mm")
        found = fitting.result()
        raise_if_asked()
        found.write(out)
        folders = [out] if isinstance(found, Fit) else [out / "first", out / "second"]
        code = write_patient(folders, code, [options.scanned, options.with_scanned][: len(folders)])
    fits = (found,) if isinstance(found, Fit) else (found.first, found.second)
    for which, fit in enumerate(fits):
        result, verdict = fit.in_metres.result, fit.verdict
        scan = f"{(options.scan, options.other)[which]}: " if len(fits) > 1 else ""
        for note in result.notes:
            print(f"breastrig: {scan}{note}", file=sys.stderr)
        for reason in verdict.reasons:
            print(f"breastrig: {scan}{LEVELS[verdict.level]}{reason}", file=sys.stderr)
        for pick in result.landmarks_not_followed:
            print(f"breastrig: {scan}{pick.reason}", file=sys.stderr)
        for pick in result.landmarks_unusual:
            print(f"breastrig: {scan}{_to_check(pick.reason)}", file=sys.stderr)
        for missing in result.drawing_missing:
            print(f"breastrig: {scan}{missing}", file=sys.stderr)
        if sys.stdout.isatty():
            print(f"{scan}{summary(result)}; patient {code}, results in {options.output}")
    if any(fit.verdict.level == "unusable" for fit in fits):
        return UNUSABLE
    return MISFIT if any(fit.drawing_missing for fit in fits) else 0


def _mm(distance: float | None) -> str:
    """None where the scan shows no skin near the model."""
    return "no distance" if distance is None else f"{distance:.2f} mm"


def summary(result: ResultFile) -> str:
    """What a result.json says in one line: first what it is good for, distances to the skin after that."""
    level = result.verdict.level if result.verdict else "check"
    sure = "" if level == "unusable" else sure_text(result.line_error_mm, list(result.landmark_uncertainty_mm.values()))
    found, alone = (_mm(each.surface_distance_mm.mean) for each in (result, result.distances))
    to_scan = f"{found} to the scan" + (f" (the model alone {alone})" if result.refined else "")
    picks = result.landmark_distance_mm.mean
    to_picks = "" if picks is None else f", {picks:.2f} mm to the landmarks"
    return f"{SAID[level]}{sure and f': {sure}'}; {to_scan}{to_picks}"
