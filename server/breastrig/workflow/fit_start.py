"""Where a fit starts and in which stance: found from landmarks and scan, or taken over from an earlier fit.

Going on from an earlier fit of the same scan is for a person who moves one pick and looks at the result: finding start
and stance costs more than the iterations that are then needed.  The result is that of a fresh fit with the same picks,
up to what the last iterations leave open (0.1 to 0.6 mm on average, measured with picks moved by 10 mm).
"""

from dataclasses import replace

from breastrig.core.errors import BadSettings
from breastrig.core.stances import AUTO, PRONE
from breastrig.fitting.body.hanging import body_axes
from breastrig.fitting.body.hanging_start import hanging_shapes
from breastrig.fitting.prepare_scan import PreparedScan
from breastrig.fitting.scan_orientation import ScanOrientation
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
from breastrig.fitting.task import FitTask
from breastrig.gltf.pose_nodes import posed_by_nodes
from breastrig.rig.skinning import pose
from breastrig.workflow.jobs import EarlierFit


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


def with_earlier_start(task: FitTask, stance: str, earlier: EarlierFit) -> tuple[FitTask, FoundStance]:
    """Start and stance of an earlier fit.

    Raises BadSettings when another rig made that fit.
    """
    if earlier.model_sha256 != task.rig.sha256:
        raise BadSettings("The fit to go on from was made with another model; fit the scan anew.")
    start = posed_by_nodes(task.rig, earlier.nodes)
    found = FoundStance(earlier.stance, "As in the fit that this one goes on from.")
    if stance != AUTO:
        found = FoundStance(stance, "As asked for.")
    hanging = hanging_shapes(task.rig, start, task.recipe)
    return replace(task, start=start, recipe=task.recipe.continued, stance=found.stance, hanging=hanging), found
