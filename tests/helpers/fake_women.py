"""Fits that say something of the torso's bodies, for a service that learns a prior; importable by worker processes."""

import hashlib
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from breastrig.fitting.uncertainty.contribution import built_in
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.cohort_prior import CohortPrior, Sums, no_cohort
from breastrig.workflow.events import Done, Event, Started
from breastrig.workflow.jobs import FitJob
from helpers import fake_fit

PRIOR = "prior.json"  # beside the fit's files: what the job was given


def body(scan: bytes) -> bytes:
    """What a fit of this scan says of her body."""
    own = built_in(read_rig(default_rig_path()), "standing")
    assert own is not None
    rng = np.random.default_rng(int(hashlib.sha256(scan).hexdigest()[:8], 16))
    mean = own.mean + 0.9 * np.linalg.cholesky(own.covariance) @ rng.standard_normal(len(own.mean))
    upper = (0.1 * own.covariance)[np.triu_indices(len(mean))]
    return np.concatenate([mean, upper]).astype("<f4").tobytes()


def prior_of(count: int) -> CohortPrior:
    """Of so many women who are all alike."""
    rig = read_rig(default_rig_path())
    own = built_in(rig, "standing")
    assert own is not None
    mean = own.mean + np.linalg.cholesky(own.covariance)[:, 2]
    prior = no_cohort(rig)
    for _ in range(count):
        prior = prior.plus(replace(prior, stances={"standing": Sums.of_woman(mean, 0.1 * own.covariance)}))
    return prior


def fitted(job: FitJob) -> Iterator[Event]:
    """As the quick one, of the torso, with a body."""
    for event in fake_fit.quick(job):
        if isinstance(event, Started):
            yield event.model_copy(update={"model_sha256": read_rig(default_rig_path()).sha256})
            continue
        if isinstance(event, Done):
            (job.out / "body.bin").write_bytes(body(job.scan.read_bytes()))
            (job.out / PRIOR).write_bytes(job.prior or b"")
        yield event
