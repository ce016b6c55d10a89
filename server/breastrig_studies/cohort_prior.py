"""Measures the gain of a prior from a cohort's fits, on similar patients and on others (docs/decisions/0027).

python -m breastrig_studies.cohort_prior [--stance supine] LEARN OUT FAMILY=FOLDER ...

Each scan of LEARN is fitted with all landmarks; priors are of the first 30, 100, 300. Each scan in that stance of every
FAMILY is fitted with half of its landmarks and with none, and its left half with the landmarks on it. Errors, mean mm:
for the first two, landmarks that were not given; for the half, skin in front that it does not show, to the true one.
The share of landmarks within their radii is shown as well. Fits are kept in OUT.
"""

import argparse
import json
import sys
from collections.abc import Iterator
from dataclasses import replace
from functools import reduce
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.errors import FitFailed
from breastrig.core.private_files import write_private
from breastrig.core.stances import STANDING
from breastrig.fitting.posterior import Posterior, contribution, contribution_bytes, parsed_contribution
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.fitting.solve import checked_iterates
from breastrig.fitting.task import FitTask, ended
from breastrig.fitting.uncertainty.radii import radii
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.cohort_prior import CohortPrior, no_cohort, with_prior
from breastrig.rig.model import Rig
from breastrig_studies.cohort import Case, read_cohort
from breastrig_studies.studies.case import Fitted, Scene, read_scene
from breastrig_studies.studies.reference_fit import reference_fit
from breastrig_studies.studies.unseen import cut_fit

SIZES = (0, 30, 100, 300)  # fewer than 30 are not used
FRONT = ("breast_L", "breast_R", "chest", "belly")
HIDDEN = 0.015  # m from what the scan shows
QUESTIONS = ("half", "none", "unseen", "surface", "held")


def number_of(patient: str) -> int:
    """The number in a patient's name, by which kinds of patients alternate."""
    return int("".join(filter(str.isdigit, patient)) or 0)


def cases(folder: Path, stance: str) -> list[Case]:
    """All cases in that stance that are not of the test set."""
    return [case for case in read_cohort(folder) if case.stance == stance and not (case.held_out or case.coloured)]


def contributions(folder: Path, stance: str, kept: Path, rig: Rig, recipe: Recipe) -> Iterator[bytes]:
    """The posterior of each scan, fitted with all landmarks, as bytes."""
    kept.mkdir(parents=True, exist_ok=True)
    for case in sorted(cases(folder, stance), key=lambda case: (number_of(case.patient), case.name)):
        file = kept / f"{case.patient}_{case.name}.bin"
        if not file.is_file():
            scene = read_scene(case)
            task = FitTask(rig, scene.target, scene.start(rig, scene.landmarks), recipe, {}, case.stance)
            task = task.with_picks(scene.landmarks)
            *_, last = checked_iterates(task)
            found = contribution(Posterior(ended(task, last), last.parameters)) if last.is_finite else None
            write_private(file, contribution_bytes(found))
        yield file.read_bytes()


def priors(folder: Path, stance: str, kept: Path, rig: Rig, recipe: Recipe) -> Iterator[tuple[int, CohortPrior]]:
    """(number of patients, prior) for each of SIZES that the folder has patients for."""
    read = (parsed_contribution(each, rig, stance) for each in contributions(folder, stance, kept, rig, recipe))
    women = (replace(no_cohort(rig), stances={stance: sums}) for sums in read if sums is not None)
    prior = no_cohort(rig)
    for size in SIZES:
        prior = reduce(CohortPrior.plus, islice(women, size - prior.women), prior)
        yield prior.women, prior


def errors(scene: Scene, rigs: dict[int, Rig], recipe: Recipe) -> Iterator[dict[str, float | int | str]]:
    """mm, a row for each prior."""
    first = next(iter(rigs.values()))
    true = reference_fit(scene, first, recipe)
    names = tuple(scene.landmarks)
    alone = scene.place(first).parameters
    halves = [dict(list(scene.landmarks.items())[begin::2]) for begin in (0, 1)]
    for size, rig in rigs.items():
        row: dict[str, list[float]] = {name: [] for name in QUESTIONS}
        for picks in (*halves, {}):
            start = scene.start(rig, picks) if picks else alone
            task = FitTask(rig, scene.target, start, recipe, {}, scene.case.stance).with_picks(picks)
            *_, last = checked_iterates(task)
            if not last.is_finite:
                raise FitFailed("The fit broke down.")
            posterior = Posterior(ended(task, last), last.parameters)
            vertices, others = posterior.state.vertices, tuple(n for n in names if n not in picks)
            off = 1e3 * scene.landmark_errors(rig, vertices, others)
            row["half" if picks else "none"] += off.tolist()
            found = radii(posterior)
            if found is not None:
                row["held"] += [float(o <= 1e3 * found.landmarks[n]) for o, n in zip(off, others, strict=True)]
            row["surface"].append(1e3 * last.mean_distance)
        part = (
            None
            if true is None
            else cut_fit(scene, rig, recipe, Fitted(true.vertices, true.parameters, 0, 0, ()), "half")
        )
        if part is not None and scene.truth is not None:
            front = np.unique(np.concatenate([rig.regions[name] for name in FRONT]))
            far = part.scene.target.vertex_tree.query(part.fit.vertices[front])[0] > HIDDEN
            row["unseen"] += (1e3 * scene.truth.query(part.fit.vertices[front[far]]).distances).tolist()
        yield {"women": size, **{name: float(np.mean(values)) for name, values in row.items() if values}}


def rows(
    family: str, tested: list[Case], rigs: dict[int, Rig], recipe: Recipe, out: Path
) -> Iterator[dict[str, object]]:
    """The errors of each scan with each prior."""
    for case in tested:
        file = out / f"{family}_{case.patient}_{case.name}.json"
        if not file.is_file():
            try:
                found = list(errors(read_scene(case), rigs, recipe))
            except FitFailed:
                found = []
            write_private(file, json.dumps(found).encode())
        yield from ({"family": family, "scan": file.stem} | row for row in json.loads(file.read_text("utf-8")))


def table(found: list[dict[str, Any]]) -> Iterator[str]:
    """A line for each family and size."""
    for family in sorted({str(row["family"]) for row in found}):
        for size in sorted({int(str(row["women"])) for row in found}):
            chosen = [row for row in found if row["family"] == family and row["women"] == size]
            means = [np.mean([float(str(r[q])) for r in chosen if q in r]) for q in QUESTIONS]
            yield f"{family:12s} {size:4d} {len(chosen):3d} " + " ".join(f"{mean:6.2f}" for mean in means)


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stance", default=STANDING)
    parser.add_argument("learn", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("families", nargs="+", metavar="FAMILY=FOLDER")
    options = parser.parse_args()
    stance, out = options.stance, options.out
    rig, recipe = read_rig(default_rig_path()), load_recipe("default")
    out.mkdir(parents=True, exist_ok=True)
    known = priors(options.learn, stance, out / "learn", rig, recipe)
    rigs = {size: with_prior(rig, prior) for size, prior in known}
    folders = {name: Path(folder) for name, folder in (each.split("=") for each in options.families)}
    found = [row for name, place in folders.items() for row in rows(name, cases(place, stance), rigs, recipe, out)]
    sys.stdout.write(f"family      women scans  {'  '.join(QUESTIONS)}\n" + "\n".join(table(found)) + "\n")


if __name__ == "__main__":
    main()
