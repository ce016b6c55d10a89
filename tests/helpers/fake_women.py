"""Priors of synthetic patients, for commands that take one."""

import numpy as np

from breastrig.fitting.posterior import built_in
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.cohort_prior import CohortPrior, Sums, cohort_of_scans


def prior_of(count: int) -> CohortPrior:
    """The prior of `count` standing patients who are all alike."""
    rig = read_rig(default_rig_path())
    own = built_in(rig, "standing")
    assert own is not None
    mean = own.mean + np.linalg.cholesky(own.covariance)[:, 2]
    alike = Sums.of_woman(mean, 0.1 * own.covariance)
    return cohort_of_scans(rig, ((str(number), "standing", alike) for number in range(count)))
