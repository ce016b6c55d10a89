"""Does the patient stand or lie, when no table is in the scan, or what may be one may be a wall as well?

A table says it all (scan/orient.py), unless it may be a wall (starts/wall_behind.py): then the arms decide.  Without
one the model is fitted as if she stood and as if she lay: lying breasts are shown with less energy by the shapes of
lying breasts, and lying patients are scanned with their arms away from the body.  Each alone is ambiguous (full breasts
of a standing patient spread a little too, small ones lying hardly do), so both are weighed together.  On 24 scans of
11 virtual patients, tables cut away, standing ones scored -12.4 to -4.5 and lying ones 2.4 to 24.
"""

from dataclasses import dataclass, replace

import numpy as np

from breastrig.core.arrays import Array
from breastrig.fitting.body.hollows import energy_without_hollows
from breastrig.fitting.picks.checked_fit import checked_iterates
from breastrig.fitting.starts.wall_behind import TABLE, WALL, may_be_wall
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.scan.orient import Frame


def _arm_angles(rig: Rig, x: RigParameters) -> Array:
    """(A,) rad between each upper arm and hanging down along its grandparent, the chest."""
    angles = []
    for bone, name in zip(rig.bones, rig.bone_names, strict=True):
        if not name.startswith("upper_arm") or bone.parent is None:
            continue
        chest = rig.bones[bone.parent].parent
        if chest is not None:
            cosine = x.rotations[rig.bone_names.index(name)][:, 1] @ x.rotations[chest][:, 1]
            angles.append(float(np.arccos(np.clip(cosine, -1.0, 1.0))))
    return np.array(angles)


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
    arms = _arm_angles(task.rig, standing[-1].parameters)
    if wall:  # what a lying back costs on a table would make lying bodies dear: the arms alone decide
        away = len(arms) and arms.mean() > rule.arms_between
        return FoundStance("supine", TABLE) if away else FoundStance("standing", WALL, standing)
    if not len(arms) or arms.mean() < rule.arms_hanging:
        return FoundStance("standing", "There is no table in the scan, and the arms hang.", standing)
    supine = tuple(checked_iterates(replace(task, stance="supine")))
    as_standing, as_lying = (energy_without_hollows(task, fit[-1]) for fit in (standing, supine))
    score = as_standing - as_lying + rule.per_radian * (arms.mean() - rule.arms_between)
    if score > 0.0:
        reason = "There is no table in the scan, but breasts and arms are as in a lying patient."
        return FoundStance("supine", reason, supine)
    reason = "There is no table in the scan, and breasts and arms are as in a standing patient."
    return FoundStance("standing", reason, standing)
