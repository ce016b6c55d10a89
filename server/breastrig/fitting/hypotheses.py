"""A fit's start and stance: found from landmarks and scan, or taken over from an earlier fit.

Findings from the scan alone, once, at the upload, are then known to proposals and fits: in the scan's own frame and as
plain numbers, so that they are stored with the scan. The place of the model's rest pose belongs to one model; for
another one it is found again. Continuing from an earlier fit of the same scan is for a person who moves one pick and
looks at the result: finding start and stance costs more than the iterations that are then needed. The result is that of
a fresh fit with the same picks, up to the remaining error of the last iterations (0.1 to 0.6 mm on average, measured
with picks moved by 10 mm).
"""

import json
from dataclasses import asdict, dataclass, replace
from typing import Any, cast

import numpy as np

from breastrig.core.stances import AUTO, PRONE
from breastrig.fitting.body.hanging import hanging_shapes
from breastrig.fitting.prepare_scan import PreparedScan
from breastrig.fitting.recipe import Recipe
from breastrig.fitting.stance import FoundStance, found_stance
from breastrig.fitting.starts.orientation import (
    MIN_LANDMARKS,
    SURE_LANDMARKS,
    agree,
    best_start,
    contradicted,
    prone_start,
    start_from_landmarks,
    start_from_scan,
)
from breastrig.fitting.starts.rigid_search import OBLIQUE, turned_from
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.similarity import Similarity, body_axes, similar_parameters
from breastrig.rig.skinning import pose
from breastrig.scan.orient import Frame

SURE_MARGIN = 0.3  # of start_from_scan; whole scans have 0.28 to 1.1


@dataclass(frozen=True, eq=False)
class ScanOrientation:
    """The orientation of one scan, for one model."""

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
    """The orientation stored in `facts`; None where none is, in another form, or if it was found with another model."""
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


def with_start(task: FitTask, scan: PreparedScan, orientation: ScanOrientation | None) -> tuple[FitTask, float | None]:
    """The task with a start found for its scan and landmarks, and how clear that is (Start.margin).

    None where landmarks placed it.  `orientation` is that of the scan when it is known already.
    """
    if orientation is None and len(task.landmarks) < MIN_LANDMARKS:
        found = start_from_scan(task.rig, task.target, scan.frame.fronts, scan.frame.known)
        return replace(task, start=found.parameters), found.margin
    known = None if orientation is None else orientation.start
    frame = scan.frame
    start = best_start(task.rig, task.target, dict(task.landmarks), lambda: frame.fronts, known, frame.known)
    clear = orientation.margin if orientation is not None and len(task.landmarks) < MIN_LANDMARKS else None
    return replace(task, start=start), clear


def with_stance(
    task: FitTask, stance: str, scan: PreparedScan, orientation: ScanOrientation | None
) -> tuple[FitTask, FoundStance]:
    """A task that has its start, in the stance that was asked for or found, and how it was found.

    The body shows its stance in a fit: the one that was made when the orientation was found, so that landmarks change
    no answer, unless they lie elsewhere than it ended; else the fit itself, which then goes on from there.
    """
    if stance != AUTO:
        found = FoundStance(stance, "As asked for.")
    elif orientation is not None and _found(task, orientation):
        found = FoundStance(orientation.stance, orientation.stance_reason)
    else:
        found = found_stance(task, scan.frame)
    task = replace(task, stance=found.stance)
    if found.stance != PRONE or len(task.landmarks) >= MIN_LANDMARKS:
        return task, found
    if found.start is None and (orientation is None or orientation.stance != PRONE):
        found = replace(found, start=prone_start(task.rig, task.target, scan.frame))
    return (task if found.start is None else replace(task, start=found.start.parameters)), found


def contradiction(task: FitTask, scan: PreparedScan, orientation: ScanOrientation | None) -> bool:
    """Whether the scan, or so many landmarks that they place a body, show it another way round than the file says."""
    if scan.frame.known is None:
        return False
    if len(task.picked) >= SURE_LANDMARKS:
        picked = pose(task.rig, start_from_landmarks(task.rig, dict(task.landmarks)))
        if turned_from(body_axes(task.rig, picked), scan.frame.known, OBLIQUE):
            return True
    if orientation is not None:
        return orientation.contradicted
    return contradicted(task.rig, task.target, scan.frame, task.stance)


def _found(task: FitTask, orientation: ScanOrientation) -> bool:
    """Whether the fit of the orientation ended where the landmarks are; True where there is no such fit, or none."""
    fitted = orientation.fitted
    return fitted is None or not task.landmarks or agree(task.rig, fitted, task.landmarks)


def continued(task: FitTask, stance: str, earlier: str, start: RigParameters) -> tuple[FitTask, FoundStance]:
    """The task going on from the `start` at which a fit in an `earlier` stance ended, in that one unless asked for."""
    found = FoundStance(earlier, "As in the fit that this one goes on from.")
    if stance != AUTO:
        found = FoundStance(stance, "As asked for.")
    hanging = hanging_shapes(task.rig, start, task.recipe)
    return replace(task, start=start, recipe=task.recipe.continued, stance=found.stance, hanging=hanging), found
