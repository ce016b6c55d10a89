"""Fits that say something of the torso's bodies, for a service that learns a prior; importable by worker processes.

As a program, `fake_women.py DATA N`: N women with a fit each, in the data folder of a service.
"""

import hashlib
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from breastrig.execution.limits import FitLimits
from breastrig.fitting.uncertainty.contribution import built_in
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.cohort_prior import CohortPrior, Sums, cohort_of_scans
from breastrig.service.service import Service
from breastrig.storage.folders import new_id
from breastrig.storage.rows.fits import NewFit
from breastrig.storage.rows.scans import ScanRow, add_scan
from breastrig.storage.storage import Storage, utc_now
from breastrig.workflow.events import Done, Event, Started
from breastrig.workflow.jobs import FitJob
from helpers import fake_fit
from helpers.waiting import ended

FACTS: dict[str, Any] = {
    "unit": "mm",
    "unit_reason": "A test said so.",
    "vertices": 3,
    "triangles": 1,
    "bounds_m": {"min": [0, 0, 0], "max": [1, 1, 1]},
    "colours": "none",
    "notes": [],
    "frame": {"up": [0, 1, 0], "front": [0, 0, 1], "confidence": 1, "reason": "A test said so."},
    "stance": {"proposed": "standing", "reason": "A test said so."},
}
PRIOR = "prior.json"  # beside the fit's files: what the job was given


def body(scan: bytes) -> bytes:
    """What a fit of this scan says of her body; all women are alike in ten directions."""
    own = built_in(read_rig(default_rig_path()), "standing")
    assert own is not None
    rng = np.random.default_rng(int(hashlib.sha256(scan).hexdigest()[:8], 16))
    away = rng.standard_normal(len(own.mean)) + 3.0 * (np.arange(len(own.mean)) < 10)
    mean = own.mean + 0.9 * np.linalg.cholesky(own.covariance) @ away
    upper = (0.1 * own.covariance)[np.triu_indices(len(mean))]
    return np.concatenate([mean, upper]).astype("<f4").tobytes()


def prior_of(count: int) -> CohortPrior:
    """Of so many women who are all alike."""
    rig = read_rig(default_rig_path())
    own = built_in(rig, "standing")
    assert own is not None
    mean = own.mean + np.linalg.cholesky(own.covariance)[:, 2]
    alike = Sums.of_woman(mean, 0.1 * own.covariance)
    return cohort_of_scans(rig, ((str(number), "standing", alike) for number in range(count)))


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


@contextmanager
def serving(storage: Storage, learns: bool) -> Iterator[Service]:
    limits = FitLimits(workers=1, grace_s=0.1)
    service = Service(Storage(storage.root), runner=fitted, fits=limits, keep_days=None, learn_prior=learns)
    with service.started():
        yield service


def add_woman(storage: Storage, content: bytes) -> str:
    scan_id = new_id()
    storage.folders.make(f"scans/{scan_id}")
    (storage.folders.scan(scan_id) / "scan.ply").write_bytes(content)
    add_scan(storage, ScanRow(scan_id, utc_now(), "ply", "ab" * 32, FACTS))
    return scan_id


def fit(service: Service, scan: str, stance: str = "standing") -> str:
    found = ended(service, service.add_fit(NewFit(scan=scan, stance=stance, landmarks_mm={})))
    assert found.state == "done"
    return found.id


if __name__ == "__main__":
    from helpers import fake_women

    with fake_women.serving(Storage(Path(sys.argv[1])), learns=False) as all_women:
        for number in range(int(sys.argv[2])):
            fit(all_women, add_woman(all_women.storage, f"woman {number}".encode()))
