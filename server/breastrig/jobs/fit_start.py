"""Where a fit starts and in which stance: found from landmarks and scan, or taken over from an earlier fit.

Going on from an earlier fit of the same scan is for the hand that moves one pick and looks: finding start and stance
costs more than the iterations that are then needed.  The picks are where they are, so the result is that of a fresh
fit, up to what the last iterations leave open (0.1 to 0.6 mm on average, measured with picks moved by 10 mm).
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.errors import BadSettings
from breastrig.fitting.orientation import best_start
from breastrig.fitting.stance import found_stance
from breastrig.fitting.task import FitTask
from breastrig.gltf.pose_nodes import posed_by_nodes
from breastrig.scan.orient import propose_frame

AUTO = "auto"


@dataclass(frozen=True)
class EarlierFit:
    """A fit of the same scan: its stance, and its last pose in glTF's words, in the scan's frame (m)."""

    stance: str
    nodes: list[dict[str, Any]]
    model_sha256: str  # of the rig whose nodes they are


def with_start(task: FitTask, stance: str) -> tuple[FitTask, str]:
    """The task with start and stance found for its scan and landmarks, and why that stance."""
    frame = propose_frame(task.target.vertices, task.target.faces)
    task = replace(task, start=best_start(task.rig, task.target, dict(task.landmarks), frame.fronts))
    found, reason = found_stance(task, frame) if stance == AUTO else (stance, "As asked for.")
    return replace(task, stance=found), reason


def with_earlier_start(task: FitTask, stance: str, earlier: EarlierFit, centre: Array) -> tuple[FitTask, str]:
    """The same from an earlier fit; `centre` (3,) m is where the task's frame has its origin in the scan's.

    Raises BadSettings when another rig made that fit.
    """
    if earlier.model_sha256 != task.rig.sha256:
        raise BadSettings("The fit to go on from was made with another model; fit the scan anew.")
    start = posed_by_nodes(task.rig, earlier.nodes).moved(np.eye(3), -centre)
    asked = stance != AUTO
    task = replace(task, start=start, recipe=task.recipe.continued, stance=stance if asked else earlier.stance)
    return task, "As asked for." if asked else "As in the fit that this one goes on from."
