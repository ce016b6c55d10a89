"""`breastrig fit SCAN -o OUT`: one scan in, five files out."""

import argparse
import sys
from pathlib import Path

from threadpoolctl import threadpool_limits
from tqdm import tqdm

from breastrig.core.errors import BadScan
from breastrig.core.units import METRES_PER_UNIT
from breastrig.jobs.events import Done, Iterated, Started
from breastrig.jobs.run_fit import STANCES, FitJob, run_fit
from breastrig.scan.landmark_files import read_landmarks
from breastrig.scan.read import read_scan


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    parser = commands.add_parser("fit", help="fit the model to one scan", description=__doc__)
    parser.add_argument("scan", type=Path, metavar="SCAN", help="PLY, OBJ, STL, GLB, or a zip of one with its images")
    parser.add_argument("--landmarks", type=Path, metavar="FILE", help="picked points: JSON, CSV, .pp or .mrk.json")
    parser.add_argument("--units", default="auto", choices=["auto", *METRES_PER_UNIT], help="unit of the scan")
    parser.add_argument("--stance", default="auto", choices=STANCES)
    parser.add_argument("--preset", default="default", metavar="NAME", help="default, paper, or a TOML file")
    parser.add_argument("--model", type=Path, metavar="GLB", help="another rig of the same form")
    parser.add_argument("--drawing", default="lumpectomy", metavar="NAME", help="a drawing of the model, or none")
    parser.add_argument("--refine", action="store_true", help="add a smooth free-form layer where the scan shows skin")
    parser.add_argument("--no-progress", action="store_true", help="no progress bar")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT", help="folder for the results")
    parser.set_defaults(run=run)


def landmarks_in_mm(file: Path | None, scan: Path, units: str) -> dict[str, list[float]]:
    """A landmark file's points in mm; without a unit of its own it has the scan's."""
    if file is None:
        return {}
    places, unit = read_landmarks(file)
    factor = 1e3 * (METRES_PER_UNIT[unit] if unit else read_scan(scan, None, units, texture=False).metres_per_unit)
    return {name: [factor * float(value) for value in place] for name, place in places.items()}


def run(options: argparse.Namespace) -> int:
    """Fits and writes; returns 0."""
    if not options.scan.is_file():
        raise BadScan(f"There is no scan file {options.scan}; check the name.")
    job = FitJob(
        scan=options.scan,
        out=options.output,
        landmarks_mm=landmarks_in_mm(options.landmarks, options.scan, options.units),
        units=options.units,
        stance=options.stance,
        preset=options.preset,
        drawing=None if options.drawing == "none" else options.drawing,
        model=options.model,
        refine=options.refine,
    )
    quiet = options.no_progress or not sys.stderr.isatty()
    with threadpool_limits(1), tqdm(disable=quiet, unit="step", leave=False) as bar:
        for event in run_fit(job):
            if isinstance(event, Started):
                bar.reset(event.iterations_limit)
            elif isinstance(event, Iterated):
                bar.update(event.iteration - bar.n)
                bar.set_postfix_str(f"{event.stage}, {event.mean_distance_mm:.2f} mm")
            elif isinstance(event, Done):
                result = event.result
    doubted = result["landmarks_not_followed"]
    assert isinstance(doubted, list)
    for pick in doubted:
        print(f"breastrig: {pick['reason']}", file=sys.stderr)
    surface, landmarks = result["surface_distance_mm"], result["landmark_distance_mm"]
    assert isinstance(surface, dict)
    assert isinstance(landmarks, dict)
    if sys.stdout.isatty():
        to_landmarks = "" if landmarks["mean"] is None else f", {landmarks['mean']:.2f} mm to the landmarks"
        print(f"{surface['mean']:.2f} mm to the scan{to_landmarks}; results in {options.output}")
    return 0
