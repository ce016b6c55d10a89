"""Probability that a body without a visible table is supine, from four signs of a fit that assumes it stands.

Signs: arms away from the trunk; nipples in front of the xiphoid, and apart, in units of the sternum's length; energy of
the supine shapes, clipped.  Weights: stance_signs.toml, estimated by breastrig_studies/stance_signs.py; evidence:
docs/decisions/0004.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.settings_file import SettingsPart, packaged
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.body.hanging import body_axes
from breastrig.fitting.body.relief import energy_without_relief
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import pose

MEASURED = ("suprasternal_notch", "xiphoid", "nipple_L", "nipple_R")
SHOWN = 0.015  # m from the scan


class Sign(SettingsPart):
    between: float  # its value that says nothing
    weight: float  # of the log odds of a supine body, for one unit more
    most: float | None = None  # farther from `between` it counts no more


class StanceSigns(SettingsPart):
    unsure: float  # log odds, either way, up to which the answer is doubted
    signs: dict[str, Sign]

    def log_odds(self, seen: Mapping[str, float]) -> float:
        """That she lies; what was not seen says nothing."""
        return sum(self._counted(name, value) for name, value in seen.items())

    def _counted(self, name: str, value: float) -> float:
        sign, away = self.signs[name], value - self.signs[name].between
        return sign.weight * (away if sign.most is None else float(np.clip(away, -sign.most, sign.most)))


@dataclass(frozen=True)
class LikelyStance:
    """Which stance the signs speak for, and whether they do so clearly."""

    supine: bool
    sure: bool


@lru_cache(maxsize=1)
def stance_signs() -> StanceSigns:
    return packaged(StanceSigns, "breastrig.fitting.starts", "stance_signs.toml")


def arm_angles(rig: Rig, x: RigParameters) -> Array:
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


def breast_signs(rig: Rig, vertices: Array, target: ScanTarget) -> dict[str, float]:
    """How (V, 3) m vertices show the breasts, in lengths of the breastbone; nothing of a rig without its landmarks.

    Where the scan does not show both nipples the model puts the other one too near: how far they are apart is not seen.
    """
    if not set(MEASURED) <= set(rig.landmark_names):
        return {}
    places = rig.landmark_points(MEASURED).positions(vertices, rig.faces)
    notch, end, *nipples = places @ body_axes(rig, vertices)
    bone = float(np.linalg.norm(notch - end))
    seen = {"nipples_in_front": float(np.mean(nipples, axis=0)[2] - end[2]) / bone}
    if np.isfinite(target.vertex_tree.query(places[2:], distance_upper_bound=SHOWN)[0]).all():
        seen["nipples_apart"] = float(nipples[0][0] - nipples[1][0]) / bone
    return seen


def measured_signs(task: FitTask, standing: FitIterate, supine: FitIterate | None = None) -> dict[str, float]:
    """What the ends of a task's fits in both stances show, by the signs' names; of one fit no energy."""
    seen = breast_signs(task.rig, pose(task.rig, standing.parameters), task.target)
    arms = arm_angles(task.rig, standing.parameters)
    if len(arms):
        seen["arms"] = float(arms.mean())
    if supine is not None:
        seen["energy_less"] = energy_without_relief(task, standing) - energy_without_relief(task, supine)
    return seen


def likely_stance(seen: Mapping[str, float]) -> LikelyStance:
    signs = stance_signs()
    odds = signs.log_odds(seen)
    return LikelyStance(odds > 0.0, abs(odds) > signs.unsure)
