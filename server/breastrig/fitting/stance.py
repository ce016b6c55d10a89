"""Does the patient stand or lie, when no table is in the scan, or what may be one may be a wall as well?

A table says it all (scan/orient.py), unless it may be a wall (starts/wall_behind.py): then the arms decide.  Without
one the model is fitted as if she stood and, unless the arms hang, as if she lay; what the fits show is weighed together
(starts/supine_or_standing.py).  Where it says little the answer says so, and asks.
"""

from dataclasses import dataclass, replace

from breastrig.fitting.picks.checked_fit import checked_iterates
from breastrig.fitting.starts.supine_or_standing import arm_angles, likely_stance, measured_signs
from breastrig.fitting.starts.wall_behind import TABLE, WALL, may_be_wall
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.scan.orient import Frame

ARMS_HANG = "There is no table in the scan, and the arms hang."
ARMS_HANG_BUT = "Without a table it is not clear: arms hang, breasts look lying. If she lies, say that she lies."
LIES = "There is no table in the scan, but breasts and arms are as in a lying patient."
STANDS = "There is no table in the scan, and breasts and arms are as in a standing patient."
MAY_LIE = "Without a table it is not clear: she seems to lie. If she stands, say that she stands."
MAY_STAND = "Without a table it is not clear: she seems to stand. If she lies, say that she lies."


@dataclass(frozen=True, eq=False)
class FoundStance:
    """A stance, why, and the fit that showed it: all iterates of the task in it, none where no fit was needed."""

    stance: str  # standing | supine
    reason: str
    iterates: tuple[FitIterate, ...] = ()


def found_stance(task: FitTask, frame: Frame) -> FoundStance:
    """For a task whose start is right and whose stance does not matter yet.

    Whoever fits the task next goes on from the iterates, so that nothing is fitted twice.
    """
    rule, wall = task.recipe.stance_rule, may_be_wall(task, frame)
    lies = frame.stance == "supine" and not wall
    if lies or not any(shape.kind == "gravity" for shape in task.rig.shapes):
        return FoundStance(frame.stance, frame.stance_reason)
    standing = tuple(checked_iterates(replace(task, stance="standing")))
    arms = arm_angles(task.rig, standing[-1].parameters)
    if wall:  # what a lying back costs on a table would make lying bodies dear: the arms alone decide
        away = len(arms) and arms.mean() > rule.arms_between
        return FoundStance("supine", TABLE) if away else FoundStance("standing", WALL, standing)
    if not len(arms) or arms.mean() < rule.arms_hanging:
        likely = likely_stance(measured_signs(task, standing[-1]))
        return FoundStance("standing", ARMS_HANG if likely.sure and not likely.supine else ARMS_HANG_BUT, standing)
    supine = tuple(checked_iterates(replace(task, stance="supine")))
    likely = likely_stance(measured_signs(task, standing[-1], supine[-1]))
    if likely.supine:
        return FoundStance("supine", LIES if likely.sure else MAY_LIE, supine)
    return FoundStance("standing", STANDS if likely.sure else MAY_STAND, standing)
