"""How a patient lies in her scan, found from the scan alone: once, at the upload, then known to proposals and fits.

In the scan's own frame and as plain numbers, so that it is kept with the scan.  The place of the model's rest pose
belongs to one model; another one has to look anew.
"""

import json
from dataclasses import asdict, dataclass, replace
from typing import Any, cast

import numpy as np

from breastrig.core.stances import PRONE
from breastrig.fitting.prepare_scan import PreparedScan
from breastrig.fitting.recipe import Recipe
from breastrig.fitting.stance import found_stance
from breastrig.fitting.starts.orientation import contradicted, prone_start, start_from_scan
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.similarity import Similarity, similar_parameters
from breastrig.scan.orient import Frame

SURE_MARGIN = 0.3  # of start_from_scan; whole scans have 0.28 to 1.1


@dataclass(frozen=True, eq=False)
class ScanOrientation:
    """Of one scan, for one model."""

    model_sha256: str
    frame: Frame  # as seen on the scan, before the model was tried
    start: Similarity  # of the model's rest pose in the scan's frame (m)
    margin: float  # see fitting/starts/orientation.py: how clear the start is
    stance: str  # standing | supine | prone
    stance_reason: str
    fitted: RigParameters | None = None  # where the fit without landmarks ended; None: the stance took none
    hanging: tuple[str, ...] = ()  # shapes by which breasts were seen to hang in that fit
    contradicted: bool = False  # whether the scan clearly shows its body another way round than the file says

    def body_frame(self) -> dict[str, Any]:
        """Up and front of the body as the model found them, for the page's camera."""
        return {
            "up": self.start.rotation[:, 1].tolist(),
            "front": self.start.rotation[:, 2].tolist(),
            "confidence": round(float(np.clip(self.margin / SURE_MARGIN, 0.0, 1.0)), 2),
            "reason": "This is how the model fits best; turn the view if it is wrong.",
        }

    def facts(self) -> dict[str, Any]:
        """Plain values, ready for JSON."""
        return cast(dict[str, Any], json.loads(json.dumps(asdict(self), default=np.ndarray.tolist)))


def orientation_from(facts: dict[str, Any] | None, rig: Rig) -> ScanOrientation | None:
    """What `facts` has stored; None where nothing is stored, in another form, or it was found with another model."""
    if facts is None or facts["model_sha256"] != rig.sha256 or "frame" not in facts:
        return None
    seen, start, fitted = facts["frame"], facts["start"], facts.get("fitted")
    arrays = {name: np.array(seen[name]) for name in ("up", "front", "fronts")}
    planes = [None if each is None else (np.array(each[0]), each[1]) for each in (seen["table"], *seen["background"])]
    return ScanOrientation(
        **facts
        | {
            "frame": Frame(**seen | arrays | {"table": planes[0], "background": tuple(planes[1:])}),
            "start": Similarity(start["scale"], np.array(start["rotation"]), np.array(start["translation"])),
            "fitted": None if fitted is None else RigParameters.of_numbers(fitted),
            "hanging": tuple(facts["hanging"]),
        }
    )


def scan_orientation(
    rig: Rig, scan: PreparedScan, recipe: Recipe
) -> tuple[ScanOrientation, FitTask, tuple[FitIterate, ...]]:
    """The orientation, the task of fitting the scan without landmarks, and its iterates where the stance took a fit."""
    start = start_from_scan(rig, scan.target, scan.frame.fronts, scan.frame.known)
    task = FitTask(rig, scan.target, start.parameters, recipe, {})
    found = found_stance(task, scan.frame, start.opening)
    if found.stance == PRONE:
        start = found.start or prone_start(rig, scan.target, scan.frame)
        task = replace(task, start=start.parameters)
    last = found.iterates[-1] if found.iterates and found.iterates[-1].is_finite else None
    orientation = ScanOrientation(
        rig.sha256,
        scan.frame,
        start.similarity,
        start.margin,
        found.stance,
        found.reason,
        None if last is None else last.parameters,
        () if last is None else last.hanging,
        contradicted(rig, scan.target, scan.frame, found.stance),
    )
    return orientation, replace(task, stance=found.stance), found.iterates


def orientation_task(rig: Rig, scan: PreparedScan, orientation: ScanOrientation, recipe: Recipe) -> FitTask:
    """The task of fitting the scan without landmarks from where it was found to lie."""
    start = similar_parameters(rig, orientation.start)
    return FitTask(rig, scan.target, start, recipe, {}, stance=orientation.stance)
