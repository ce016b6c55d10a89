"""Refits a finished fit's model to moved landmarks, in a process that is kept for that fit.

For a person who drags a landmark. The first question reads, cleans and indexes the scan; the prepared scan stays in the
process's memory, so that the next ones cost a few iterations. The process serves one fit and ends with its deletion
(execution/pool.py).
"""

import time
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.clock import Clock
from breastrig.core.errors import FitFailed
from breastrig.fitting.picks.moved_landmarks import FittedScan
from breastrig.gltf.pose_nodes import node_poses
from breastrig.rig.model import Rig
from breastrig.use.steps.prepare import checked_landmarks, fit_plan, prepare_fit, read_model, scan_of_job
from breastrig.use.steps.settings import FitJob

LOST = "The model lost the scan at these landmarks; put the moved one back, or fit anew."


@dataclass(frozen=True, eq=False)
class _Prepared:
    rig: Rig
    fitted: FittedScan
    left_out: Mapping[str, Array]  # picks that the fit did not follow, while they stand where they stood


_prepared: dict[str, _Prepared] = {}  # of this process, by what the caller calls the fit: one at most


def moved_landmarks(fit: str, landmarks_mm: dict[str, list[float]]) -> dict[str, Any] | None:
    """The model's nodes at these landmarks (scan frame); None when this process has not read the fit's scan yet."""
    prepared = _prepared.get(fit)
    return None if prepared is None else _answer(prepared, landmarks_mm)


def follow_landmarks(
    fit: str, job: FitJob, not_followed: Collection[str], landmarks_mm: dict[str, list[float]]
) -> dict[str, Any]:
    """The answer of `moved_landmarks` after reading the fit's scan. Raises BadInput with a sentence.

    `job` goes on from the fit (`earlier`), which has left out the picks `not_followed`.
    """
    rig = read_model(job)
    plan = fit_plan(job, rig, job.landmarks_mm)
    task = prepare_fit(plan, scan_of_job(job), Clock()).hypothesis.task
    left_out = plan.proposed | {name: plan.landmarks[name] for name in not_followed if name in plan.landmarks}
    _prepared.clear()
    _prepared[fit] = _Prepared(rig, FittedScan(task), left_out)
    return _answer(_prepared[fit], landmarks_mm)


def _answer(prepared: _Prepared, landmarks_mm: dict[str, list[float]]) -> dict[str, Any]:
    began = time.perf_counter()
    picked = checked_landmarks(prepared.rig, landmarks_mm)
    left_out = prepared.left_out
    followed = {name: place for name, place in picked.items() if not _same(left_out.get(name), place)}
    last = prepared.fitted.moved(followed)
    if not last.is_finite:
        raise FitFailed(LOST)
    gap = last.landmark_distance
    return {
        "nodes": node_poses(prepared.rig, last.parameters),
        "mean_distance_mm": round(1e3 * last.mean_distance, 4),
        "landmark_distance_mm": None if gap is None else round(1e3 * gap, 4),
        "coverage": round(last.coverage, 4),
        "elapsed_s": round(time.perf_counter() - began, 4),
    }


def _same(before: Array | None, now: Array) -> bool:
    return before is not None and bool(np.abs(before - now).max() < 1e-6)
