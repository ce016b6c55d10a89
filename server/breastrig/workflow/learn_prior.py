"""A service's prior, made of what its fits say of bodies."""

from typing import Any

from breastrig.fitting.body.expected_body import cohort_belief
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.uncertainty.contribution import BUILT_IN, parsed_contribution
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.cohort_prior import cohort_of_scans, with_prior
from breastrig.workflow.jobs import CohortJob


def learn_prior(job: CohortJob) -> tuple[bytes, list[dict[str, Any]]]:
    """(the file, empty where there is nobody; of each stance the patients, and how much closer one is foretold)."""
    rig = read_rig(job.model or default_rig_path())
    read = ((patient, stance, parsed_contribution(content, rig, stance)) for patient, stance, content in job.bodies)
    prior = cohort_of_scans(rig, ((patient, stance, sums) for patient, stance, sums in read if sums is not None))
    known, recipe, found = with_prior(rig, prior), load_recipe(BUILT_IN), []
    for stance, sums in prior.stances.items():
        belief = None if recipe.body is None else cohort_belief(known, recipe.shapes, recipe.body, stance)
        closer = 0.0 if belief is None else round(belief.closer, 3)
        found.append({"stance": stance, "patients": sums.women, "closer": closer})
    return (prior.content() if prior.women else b""), found
