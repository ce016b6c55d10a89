"""A finished fit, opened from its files, that answers where the model lies when landmarks are moved.

For a person who drags a landmark: the scan is read, cleaned and indexed once, and each question costs two iterations.
"""

import json
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import FitFailed
from breastrig.fitting.moved_landmarks import FittedScan
from breastrig.gltf.pose_nodes import node_poses
from breastrig.workflow.scan_fit import FitJob, checked_landmarks, fit_plan, made_ready, read_model, scan_of_job

LOST = "The model lost the scan at these landmarks; put the moved one back, or fit anew."


@dataclass(frozen=True)
class FollowJob:
    """The fit to go on from: its own job with `earlier`, and the picks that it did not follow."""

    fit: FitJob
    not_followed: tuple[str, ...]


def follow_landmarks(job: FollowJob) -> Callable[[bytes], bytes]:
    """Answers {"landmarks": {name: [x, y, z]}} (JSON; mm, scan frame) with the model's nodes there.

    A pick that the fit did not follow is left out for as long as it stands where it stood.
    """
    rig = read_model(job.fit)
    plan = fit_plan(job.fit, rig, job.fit.landmarks_mm)
    task = made_ready(plan, *scan_of_job(job.fit)).task
    fitted = FittedScan(task)
    left_out = {name: plan.landmarks[name] for name in job.not_followed if name in plan.landmarks}

    def answer(question: bytes) -> bytes:
        began = time.perf_counter()
        picked = checked_landmarks(rig, json.loads(question)["landmarks"])
        followed = {name: place for name, place in picked.items() if not _same(left_out.get(name), place)}
        last = fitted.moved(followed)
        if not last.is_finite:
            raise FitFailed(LOST)
        gap = last.landmark_distance
        document = {
            "nodes": node_poses(rig, last.parameters),
            "mean_distance_mm": round(1e3 * last.mean_distance, 4),
            "landmark_distance_mm": None if gap is None else round(1e3 * gap, 4),
            "coverage": round(last.coverage, 4),
            "elapsed_s": round(time.perf_counter() - began, 4),
        }
        return json.dumps(document, separators=(",", ":")).encode()

    return answer


def _same(before: Array | None, now: Array) -> bool:
    return before is not None and bool(np.abs(before - now).max() < 1e-6)
