"""A service's prior, made of what its fits say of bodies."""

from dataclasses import replace
from typing import Any

import numpy as np

from breastrig.fitting.body.expected_body import cohort_belief
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.uncertainty.contribution import BUILT_IN, parsed_contribution
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.cohort_prior import Sums, no_cohort, with_prior
from breastrig.workflow.jobs import CohortJob


def learn_prior(job: CohortJob) -> tuple[bytes, list[dict[str, Any]]]:
    """(the file, empty where there is nobody; of each stance its women and gain); a patient counts once in each."""
    rig, best = read_rig(job.model or default_rig_path()), dict[tuple[str, str], Sums]()
    for patient, stance, content in job.bodies:
        sums = parsed_contribution(content, rig, stance)
        key = patient, stance
        if sums is not None and (key not in best or np.trace(sums.covariances) < np.trace(best[key].covariances)):
            best[key] = sums
    prior = no_cohort(rig)
    for (_, stance), sums in best.items():
        prior = prior.plus(replace(prior, stances={stance: sums}))
    known, recipe, found = with_prior(rig, prior), load_recipe(BUILT_IN), []
    for stance, sums in prior.stances.items():
        belief = None if recipe.body is None else cohort_belief(known, recipe.shapes, recipe.body, stance)
        found.append({"stance": stance, "women": sums.women, "gain": 0.0 if belief is None else round(belief.gain, 2)})
    return (prior.content() if prior.women else b""), found
