"""Whether the patient is standing, supine or prone.

A table decides (scan/orient.py), unless plane and body are both upright in the scanner's axes.  Without one a fit as
standing shows the stance (starts/stance_signs.py); an unclear answer asks the user, and is a reason in the verdict.
"""

from dataclasses import dataclass, replace

import numpy as np

from breastrig.core.stances import PRONE, STANDING, SUPINE
from breastrig.fitting.solve import checked_iterates
from breastrig.fitting.starts.hypotheses import Opening
from breastrig.fitting.starts.orientation import Start, prone_start
from breastrig.fitting.starts.stance_signs import SCANNERS_UP, UPRIGHT, likely_stance, measured_signs
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.rig.similarity import body_axes
from breastrig.rig.skinning import pose
from breastrig.scan.orient import Frame

WALL = (
    "An upright plane is close behind, and the patient seems to stand: a wall. "
    "If it is a table, say that the patient lies."
)
TABLE = (
    "An upright plane is close behind, and the patient seems to lie: a table. "
    "If it is a wall, say that the patient stands."
)


def may_be_wall(task: FitTask, frame: Frame) -> bool:
    """Whether the plane behind the body is upright in the scanner's own axes, and the body at its start as well."""
    if frame.table is None:
        return False
    up = body_axes(task.rig, pose(task.rig, task.start))[:, 1]
    return bool(np.linalg.norm(np.cross(frame.table[0], SCANNERS_UP)) > UPRIGHT and up @ SCANNERS_UP > UPRIGHT)


LIES = "There is no table in the scan, but the patient seems to lie."
STANDS = "There is no table in the scan, and the patient seems to stand."
MAY_LIE = "Without a table it is not clear: the patient seems to lie. If the patient stands, say so."
MAY_STAND = "Without a table it is not clear: the patient seems to stand. If the patient lies, say so."
MAY_HANG = (
    "Only a chest's front is seen, and its breasts may hang to the front: prone. "
    "If not, say how the patient was scanned."
)
HANGS = (
    "Only the front of a chest is seen, and its breasts hang to the front: prone. "
    "If not, say how the patient was scanned."
)
UNCLEAR = (MAY_LIE, MAY_STAND, MAY_HANG)
REASONS = {STANDING: (MAY_STAND, STANDS), SUPINE: (MAY_LIE, LIES), PRONE: (MAY_HANG, HANGS)}  # unsure, sure


@dataclass(frozen=True, eq=False)
class FoundStance:
    """A stance, why, and the fit that showed it: all iterates of the task in it, none where no fit was needed."""

    stance: str  # standing | supine | prone
    reason: str
    iterates: tuple[FitIterate, ...] = ()
    start: Start | None = None  # where the stance has one of its own


def found_stance(task: FitTask, frame: Frame, known_opening: Opening | None = None) -> FoundStance:
    """For a task whose start is right and whose stance does not matter yet; `known_opening` was fitted to find it.

    Whoever fits the task next goes on from the iterates, so that nothing is fitted twice.
    """
    wall = may_be_wall(task, frame)
    is_said = frame.stance == PRONE or (frame.stance == SUPINE and not wall)
    if is_said or not any(shape.kind == "gravity" for shape in task.rig.shapes):
        return FoundStance(frame.stance, frame.stance_reason)
    task = replace(task, stance=STANDING)
    standing = tuple(checked_iterates(task, _same(known_opening, task)))
    likely = likely_stance(measured_signs(task, standing[-1]))
    if wall:
        return FoundStance(STANDING, WALL, standing) if likely.stance == STANDING else FoundStance(SUPINE, TABLE)
    reason = REASONS[likely.stance][likely.sure]
    if likely.stance == STANDING:
        return FoundStance(STANDING, reason, standing)
    task = replace(task, stance=likely.stance)
    if likely.stance == SUPINE:
        return FoundStance(SUPINE, reason, tuple(checked_iterates(task)))
    start = prone_start(task.rig, task.target, frame)
    task = replace(task, start=start.parameters)
    return FoundStance(PRONE, reason, () if task.landmarks else tuple(checked_iterates(task)), start)


def _same(opening: Opening | None, task: FitTask) -> Opening | None:
    """The opening, if it is this task's."""
    if opening is None or task.landmarks:
        return None
    return opening if opening.task.stance == task.stance and opening.task.recipe is task.recipe else None
