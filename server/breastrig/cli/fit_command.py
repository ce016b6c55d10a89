"""`breastrig fit SCAN -o OUT`: one scan in, seven files out.

With `--with SCAN_B` two stances of one patient are fitted together, with one body: OUT/first and OUT/second get the
seven files each, OUT/pair.json says what they share.
"""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits
from tqdm import tqdm

from breastrig.cli.interruption import raise_if_asked
from breastrig.cli.output_options import add_output_options, files_of_model, fit_set, output_folder
from breastrig.core.errors import BadScan, BadSettings
from breastrig.core.output_files import Output
from breastrig.core.output_record import OutputSet
from breastrig.core.private_files import is_ordinary, shown
from breastrig.core.staged_output import all_or_nothing
from breastrig.core.units import METRES_PER_UNIT
from breastrig.drawings.patterns import pattern_help, tumour_text
from breastrig.fitting.two_stances import ALIKE, ONE_BODY
from breastrig.scan.landmark_files import landmark_confidences, read_landmarks
from breastrig.scan.read import read_scan
from breastrig.workflow.events import Done, Event, Iterated, Started
from breastrig.workflow.run_fit import STANCES, FitJob, run_fit
from breastrig.workflow.run_pair import PAIR_SCHEMA, run_pair

PAIR = "pair.json"
LEVELS = {"check": "check this fit", "unusable": "this fit is not usable"}


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("fit", help="fit the model to one scan", description=__doc__)
    parser.add_argument("scan", type=Path, metavar="SCAN", help="PLY, OBJ, STL, GLB, or a zip of one with its images")
    parser.add_argument("--landmarks", type=Path, metavar="FILE", help="picked points: JSON, CSV, .pp or .mrk.json")
    parser.add_argument("--units", default="auto", choices=["auto", *METRES_PER_UNIT], help="unit of the scan")
    parser.add_argument("--stance", default="auto", choices=STANCES)
    parser.add_argument("--with", dest="other", type=Path, metavar="SCAN_B", help="the same patient in another stance")
    parser.add_argument("--with-landmarks", type=Path, metavar="FILE", help="picked points on SCAN_B")
    parser.add_argument("--with-units", default="auto", choices=["auto", *METRES_PER_UNIT], help="unit of SCAN_B")
    parser.add_argument("--with-stance", default="auto", choices=STANCES, help="stance of SCAN_B")
    parser.add_argument(
        "--alike", action="store_true", help="with SCAN_B: bodies held alike instead of one body, as chests flatten"
    )
    parser.add_argument("--preset", default="default", metavar="NAME", help="default, paper, or a TOML file")
    parser.add_argument("--model", type=Path, metavar="GLB", help="another rig of the same form")
    parser.add_argument(
        "--drawing",
        default="lumpectomy",
        metavar="NAME",
        help="a drawing of the model (lumpectomy, anatomy, mastectomy), a pattern drawn to the patient's measures "
        "(reduction:areola_mm=42,limb_mm=50), several joined by +, or none. " + pattern_help(),
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
    parser.add_argument("--refine", action="store_true", help="add a smooth free-form layer where the scan shows skin")
    parser.add_argument("--no-progress", action="store_true", help="no progress bar")
    add_output_options(parser, "OUT", "folder for the results")
    parser.set_defaults(run=run)


def landmarks_in_mm(file: Path | None, scan: Path, units: str) -> dict[str, list[float]]:
    """A landmark file's points in mm; without a unit of its own it has the scan's."""
    if file is None:
        return {}
    places, unit = read_landmarks(file)
    factor = 1e3 * (METRES_PER_UNIT[unit] if unit else read_scan(scan, None, units, texture=False).metres_per_unit)
    return {name: [factor * float(value) for value in place] for name, place in places.items()}


def _drawing(options: argparse.Namespace) -> str | None:
    parts = [] if options.drawing == "none" else [options.drawing]
    return "+".join([*parts, *(tumour_text(short) for short in options.tumour)]) or None


def _job(options: argparse.Namespace, scan: Path, landmarks: Path | None, units: str, stance: str, out: Path) -> FitJob:
    if not is_ordinary(scan):
        raise BadScan(f"There is no scan file {shown(scan)}; check the name.")
    return FitJob(
        scan=scan,
        out=out,
        landmarks_mm=landmarks_in_mm(landmarks, scan, units),
        landmark_confidence=landmark_confidences(landmarks) if landmarks else {},
        units=units,
        stance=stance,
        preset=options.preset,
        drawing=_drawing(options),
        model=options.model,
        refine=options.refine,
    )


def _output(options: argparse.Namespace) -> Output:
    """What will be written, and what is read."""
    preset = Path(options.preset) if options.preset.endswith(".toml") else None
    inputs = [options.scan, options.landmarks, options.other, options.with_landmarks, preset]
    sets = [fit_set(Path())]
    if options.other is not None:
        pair = OutputSet(Path(), (PAIR,), PAIR, PAIR_SCHEMA)
        sets = [fit_set(Path("first")), fit_set(Path("second")), pair]
    return output_folder(options, sets, [*inputs, *files_of_model(options.model)])


def _stories(options: argparse.Namespace, out: Path) -> Iterator[tuple[int, Event]]:
    """(0, or 1 for the second scan; its next event)."""
    first = options.scan, options.landmarks, options.units, options.stance
    if options.other is None:
        yield from ((0, event) for event in run_fit(_job(options, *first, out)))
        return
    second = options.other, options.with_landmarks, options.with_units, options.with_stance
    yield from run_pair(
        _job(options, *first, out / "first"),
        _job(options, *second, out / "second"),
        out / PAIR,
        ALIKE if options.alike else ONE_BODY,
    )


def run(options: argparse.Namespace) -> int:
    """Fits and writes; returns 0."""
    given = options.with_landmarks or options.alike or (options.with_units, options.with_stance) != ("auto", "auto")
    if options.other is None and given:
        raise BadSettings("--with-landmarks, --with-units, --with-stance and --alike need --with SCAN_B.")
    results: dict[int, dict[str, Any]] = {}
    quiet = options.no_progress or not sys.stderr.isatty()
    with (
        threadpool_limits(1),
        all_or_nothing(_output(options)) as out,
        tqdm(disable=quiet, unit="step", leave=False) as bar,
    ):
        for which, event in _stories(options, out):
            raise_if_asked()
            if isinstance(event, Started):
                bar.reset(event.iterations_limit)
            elif isinstance(event, Iterated):
                bar.update(event.iteration - bar.n)
                bar.set_postfix_str(f"{event.stage}, {event.mean_distance_mm:.2f} mm")
            elif isinstance(event, Done):
                results[which] = event.result
    for which, result in results.items():
        scan = f"{(options.scan, options.other)[which]}: " if len(results) > 1 else ""
        verdict = result["verdict"]
        for reason in verdict["reasons"]:
            print(f"breastrig: {scan}{LEVELS[verdict['level']]}: {reason}", file=sys.stderr)
        for pick in result["landmarks_not_followed"]:
            print(f"breastrig: {scan}{pick['reason']}", file=sys.stderr)
        surface, landmarks = result["surface_distance_mm"], result["landmark_distance_mm"]
        if sys.stdout.isatty():
            to_landmarks = "" if landmarks["mean"] is None else f", {landmarks['mean']:.2f} mm to the landmarks"
            print(f"{scan}{surface['mean']:.2f} mm to the scan{to_landmarks}; results in {options.output}")
    return 0
