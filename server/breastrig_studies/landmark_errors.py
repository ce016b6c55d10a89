"""Writes the offsets of bodies' landmarks from the model's (fitting/body/landmarks.py).

python -m breastrig_studies.landmark_errors COHORT... [--write]

From leave-one-out residuals of all scans of the development patients, with true landmarks as picks, beyond the fit's
own uncertainty. Mean and deviation by expectation-maximisation for a Student t, so that a few unusual patients do not
decide (Lange, Little and Taylor, Robust statistical modeling using the t distribution, 1989). Without --write the
numbers are printed.
"""

import json
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.stances import split_side
from breastrig.fitting.body.landmarks import FILE, SCHEMA
from breastrig.fitting.posterior import LeaveOneOut, Posterior
from breastrig.fitting.recipe import Recipe, load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.model import Rig
from breastrig.rig.similarity import body_axes, outwards
from breastrig_studies.arguments import arguments
from breastrig_studies.cohort import Case, read_cohort
from breastrig_studies.radii_factors import fitted
from breastrig_studies.studies.case import read_scene

FREEDOM = 4.0  # of the Student t
ROUNDS = 60  # numbers change by less than 0.01 mm from then on
USUAL = 0.003  # m, deviation that counts as two observations, and mean that is expected
LEAST = 0.0005  # m
OTHER_SIDE = np.array([-1.0, 1.0, 1.0])


@dataclass(frozen=True, eq=False)
class Residual:
    """The residual of one pick, in its own axes."""

    group: str  # of patients of one origin: groups count alike
    gap: Array  # (3,) m, from where all else expects the model's landmark to the pick
    variance: Array  # (3,) m², of the fit and of the pick


Residuals = dict[tuple[str, str], list[Residual]]  # by stance and landmark, without its side


def residuals(posterior: Posterior, group: str = "") -> Iterator[tuple[str, Residual]]:
    """(landmark without its side, residual) of every pick of a fit; those in the middle also mirrored."""
    judged, task = posterior.of_picks_alone, posterior.task
    axes = body_axes(task.rig, posterior.state.vertices)
    for name, (error, covariance) in LeaveOneOut(judged).of_model().items():
        stem, side = split_side(name)
        own = axes * outwards(name)
        gap, variance = -own.T @ error, np.diag(own.T @ covariance @ own)
        yield stem, Residual(group, gap, variance)
        if not side:
            yield stem, Residual(group, gap * OTHER_SIDE, variance)


def estimate(found: Sequence[Residual]) -> tuple[Array, Array]:
    """((3,) m mean, (3,) m standard deviation) of one landmark."""
    gaps, variances = (np.array([getattr(each, part) for each in found]) for part in ("gap", "variance"))
    groups = [each.group for each in found]
    shares = np.array([1.0 / groups.count(group) for group in groups])
    shares *= len(found) / shares.sum()
    mean, spread = np.median(gaps, axis=0), np.full(3, USUAL**2)
    for _ in range(ROUNDS):
        distances = ((gaps - mean) ** 2 / (variances + spread)).sum(axis=1)
        weights = shares * (FREEDOM + 3.0) / (FREEDOM + distances)
        precisions = weights[:, None] / (variances + spread)
        mean = (precisions * gaps).sum(axis=0) / (precisions.sum(axis=0) + USUAL**-2)
        kept = spread / (variances + spread)
        squares = weights[:, None] * (kept * (gaps - mean)) ** 2 + shares[:, None] * spread * (1.0 - kept)
        spread = (squares.sum(axis=0) + 2.0 * USUAL**2) / (len(found) + 2.0)
    return mean, np.maximum(np.sqrt(spread), LEAST)


def document(found: Mapping[tuple[str, str], Sequence[Residual]]) -> dict[str, Any]:
    """The file's document."""
    stances: dict[str, dict[str, Any]] = defaultdict(dict)
    for (stance, landmark), each in sorted(found.items()):
        mean, deviation = (np.round(1e3 * values, 1).tolist() for values in estimate(each))
        stances[stance][landmark] = {"mean_mm": mean, "deviation_mm": deviation}
    return {"schema": SCHEMA, "stances": dict(stances)}


def residuals_of(cases: Iterable[Case], rig: Rig, recipe: Recipe) -> Residuals:
    """The residuals of one fit to each scan."""
    found: Residuals = defaultdict(list)
    for case in cases:
        scene = read_scene(case)
        posterior = fitted(scene, rig, recipe, dict(scene.landmarks), scene.start(rig, scene.landmarks))
        for landmark, each in residuals(posterior, case.folder.parents[1].name) if posterior is not None else ():
            found[case.stance, landmark].append(each)
    return found


def main(folders: Sequence[Path], write: bool) -> None:
    """Prints or writes the file of the torso."""
    chosen = [case for folder in folders for case in read_cohort(folder) if case.teaches]
    found = residuals_of(chosen, read_rig(default_rig_path()), load_recipe("default"))
    text = json.dumps(document(found), indent=1) + "\n"
    if write:
        (default_rig_path().with_suffix(".known") / FILE).write_text(text, "utf-8")
    sys.stdout.write(text)


if __name__ == "__main__":
    given = arguments(__doc__, "COHORT...", "--write")
    main([Path(each) for each in given.cohort], given.write)
