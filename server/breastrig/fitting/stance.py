"""Whether the patient is standing, supine or prone.

A table decides (scan/orient.py), unless plane and body are both upright in the scanner's axes.  Without one a small
front whose breasts hang forwards is prone (starts/prone.py); of others a fit as standing shows the stance
(starts/supine_or_standing.py); an unclear answer asks the user, and is a reason in the verdict.
"""

from dataclasses import dataclass, replace

import numpy as np

from breastrig.core.stances import PRONE
from breastrig.fitting.picks.checked_fit import checked_iterates
from breastrig.fitting.starts.hypotheses import Opening, judge, opened
from breastrig.fitting.starts.orientation import Start
from breastrig.fitting.starts.prone import hanging_views, prone_start
from breastrig.fitting.starts.supine_or_standing import SCANNERS_UP, UPRIGHT, likely_stance, measured_signs
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.rig.similarity import umeyama
from breastrig.rig.skinning import pose
from breastrig.scan.orient import Frame

WALL = "An upright plane is close behind her, but she stands: a wall. If it is a table, say that she lies."
TABLE = "An upright plane is close behind her, and she lies: a table. If it is a wall, say that she stands."


def may_be_wall(task: FitTask, frame: Frame) -> bool:
    """Whether the plane behind the body is upright in the scanner's own axes, and the body at its start as well."""
    if frame.table is None:
        return False
    points = task.rig.landmark_points()
    at_rest, placed = (
        points.positions(each, task.rig.faces) for each in (task.rig.template, pose(task.rig, task.start))
    )
    body = umeyama(at_rest, placed).rotation[:, 1]
    return bool(np.linalg.norm(np.cross(frame.table[0], SCANNERS_UP)) > UPRIGHT and body @ SCANNERS_UP > UPRIGHT)


LIES = "There is no table in the scan, but she looks like a lying patient."
STANDS = "There is no table in the scan, and she looks like a standing patient."
MAY_LIE = "Without a table it is not clear: she seems to lie. If she stands, say that she stands."
MAY_STAND = "Without a table it is not clear: she seems to stand. If she lies, say that she lies."
MAY_HANG = "Only a chest's front is seen, and its breasts may hang to the front: prone. If not, say how she is scanned."
UNCLEAR = (MAY_LIE, MAY_STAND, MAY_HANG)

WORSE = (
    60.0  # log likelihood that prone may lack, and has more where clear: prone -22 on, others -114, implants -17 to 1
)
HANGS = "Only the front of a chest is seen, and its breasts hang to the front: prone. If not, say how she is scanned."


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
    is_said = frame.stance == PRONE or (frame.stance == "supine" and not wall)
    if is_said or not any(shape.kind == "gravity" for shape in task.rig.shapes):
        return FoundStance(frame.stance, frame.stance_reason)
    task = replace(task, stance="standing")
    known = (
        known_opening is not None
        and known_opening.task.stance == task.stance
        and known_opening.task.recipe is task.recipe
    )
    known_opening = known_opening if known and not task.landmarks else None
    views = hanging_views(task.target, frame.front) if not wall and len(frame.fronts) == 1 else []
    prone = prone_start(task.rig, task.target, frame, views) if views else None
    if prone is not None and prone.opening is not None:
        of_scan = known_opening or opened(replace(task.with_picks({}), recipe=judge()))
        if prone.opening.energy < of_scan.energy + WORSE:
            lies = replace(task, stance=PRONE, start=prone.parameters)
            same = not task.landmarks and task.recipe is prone.opening.task.recipe
            why = HANGS if prone.opening.energy + WORSE < of_scan.energy else MAY_HANG
            return FoundStance(PRONE, why, tuple(checked_iterates(lies, prone.opening)) if same else (), prone)
    standing = tuple(checked_iterates(task, known_opening))
    likely = likely_stance(measured_signs(task, standing[-1]))
    if wall:
        return FoundStance("supine", TABLE) if likely.supine else FoundStance("standing", WALL, standing)
    if not likely.supine:
        return FoundStance("standing", STANDS if likely.sure else MAY_STAND, standing)
    supine = tuple(checked_iterates(replace(task, stance="supine")))
    return FoundStance("supine", LIES if likely.sure else MAY_LIE, supine)
