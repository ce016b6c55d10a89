"""Compares the energy around a fit with its Gaussian approximation (fitting/posterior.py).

python -m breastrig_studies.studies.trust.laplace COHORT [COHORT ...]

Steps drawn from the posterior are scaled to 1, 2 and 4 deviations; matches are searched anew at each. 1: as the
Gaussian; less: the fit is less certain there than it states. Of the first two patients of each stance.
"""

import sys
from collections import Counter
from pathlib import Path

import numpy as np

from breastrig.core.arrays import Array
from breastrig.fitting.fit import ScanProblem
from breastrig.fitting.posterior import Posterior
from breastrig.fitting.recipe import load_recipe
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig_studies.arguments import arguments
from breastrig_studies.cohort import read_cohort
from breastrig_studies.radii_factors import fitted
from breastrig_studies.studies.case import read_scene

DEVIATIONS = (1.0, 2.0, 4.0)
STEPS = 16
WOMEN = 2  # of a cohort in each stance
SEED = 1


def rises(posterior: Posterior) -> Array:
    """(DEVIATIONS, STEPS) of the energy over half the squared deviations."""
    problem, stage = ScanProblem(posterior.task), posterior.task.recipe.stages[-1]
    problem.relief, problem.partners = posterior.relief, posterior.partners
    precision = np.linalg.inv(posterior.covariance())
    random = np.random.default_rng(SEED)

    def energy(step: Array) -> float:
        state = posterior.state.retract(step)
        return problem.energy(problem.terms(stage, 1.0, state, problem.matches(stage, 1.0, state)), state)

    ended = energy(np.zeros(posterior.state.dof))
    steps = [posterior.sample(random) for _ in range(STEPS)]
    steps = [step / np.sqrt(step @ precision @ step) for step in steps]
    return np.array([[(energy(size * step) - ended) / (0.5 * size**2) for step in steps] for size in DEVIATIONS])


def main(folders: list[str]) -> None:
    """A line for each fit: the median, and what a tenth is below and above."""
    rig, recipe, seen = read_rig(default_rig_path()), load_recipe("default"), Counter[tuple[str, str]]()
    for folder in folders:
        for case in read_cohort(Path(folder)):
            seen[folder, case.stance] += 1
            if seen[folder, case.stance] > WOMEN or case.held_out:
                continue
            scene = read_scene(case)
            for picks in (dict(scene.landmarks), {}):
                start = scene.start(rig, picks) if picks else scene.place(rig).parameters
                posterior = fitted(scene, rig, recipe, picks, start)
                if posterior is not None:
                    shares = np.percentile(rises(posterior), [10, 50, 90], axis=1).T
                    text = "   ".join("{:5.1f} {:5.1f} {:5.1f}".format(*row) for row in shares)
                    sys.stdout.write(f"{case.patient} {case.name} {'picks' if picks else 'none'}: {text}\n")


if __name__ == "__main__":
    given = arguments(__doc__, "COHORT...")
    main(given.cohort)
