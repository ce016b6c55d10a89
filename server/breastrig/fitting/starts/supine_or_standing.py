"""Probability that a body without a visible table is supine, from the signs of a fit that assumes it stands.

Arms say little: standing ones may be anywhere.  Breasts say most, by the one that is more in front, as the other may be
gone: where nipple is to breastbone and fold, in units of the breastbone's length, and the shapes by which breasts
flatten and lie aside.  Skin that faces backwards is seen of a standing body only.  All counts in proportion to the
breast's length, for small ones lie as they stand.  Weights: stance_signs.toml, by breastrig_studies/stance_signs.py;
docs/decisions/0022.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from breastrig.core.arrays import Array
from breastrig.core.settings_file import SettingsPart, packaged
from breastrig.core.stances import SIDES
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.body.hanging import body_axes
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.geometry.normals import face_crosses
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import pose

MEASURED = ("suprasternal_notch", "xiphoid", "nipple_L", "nipple_R", "inframammary_fold_L", "inframammary_fold_R")
SHAPES = {"flattened": "projection", "aside": "position_lateral"}  # signs that are weights of a shape
BACKWARDS = -0.3  # cosine to the front; a lying body is seen from above
TRUNK = (
    (-0.5, 0.75),
    0.8,
)  # lengths of the breastbone: heights over the xiphoid, and to the sides, between which no arm is
SCANNERS_UP = np.array([0.0, 1.0, 0.0])  # as scan/orient.py has it
UPRIGHT = np.cos(np.radians(15.0))  # people lean, and apps level to a few degrees


class Sign(SettingsPart):
    between: float  # its value that says nothing
    weight: float  # of the log odds of a supine body, for one unit more
    most: float  # farther from `between` it counts no more
    by_hand: bool = False  # not estimated: simulated scans are turned at random


class StanceSigns(SettingsPart):
    unsure: float  # log odds, either way, up to which the answer is doubted
    constant: float  # log odds where no sign says anything
    length: float  # of a usual breast, from fold to nipple, in lengths of the breastbone
    signs: dict[str, Sign]

    def log_odds(self, seen: Mapping[str, float]) -> float:
        """That she lies; what was not seen says nothing."""
        all_signs = self.constant + sum(self._counted(name, seen[name]) for name in self.signs if name in seen)
        return all_signs * seen.get("length", self.length) / self.length

    def _counted(self, name: str, value: float) -> float:
        sign = self.signs[name]
        return sign.weight * float(np.clip(value - sign.between, -sign.most, sign.most))


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


def breast_signs(rig: Rig, x: RigParameters, vertices: Array, target: ScanTarget) -> dict[str, float]:
    """How (V, 3) m vertices, posed by `x`, show the breasts, in lengths of the breastbone; nothing of a rig without
    its landmarks."""
    if not set(MEASURED) <= set(rig.landmark_names):
        return {}
    axes = body_axes(rig, vertices)
    notch, end, *breasts = rig.landmark_points(MEASURED).positions(vertices, rig.faces) @ axes
    side, nipple, fold = max(zip(SIDES, breasts[:2], breasts[2:], strict=True), key=lambda each: float(each[1][2]))
    bone = float(np.linalg.norm(notch - end))
    weights = dict(zip(rig.shape_names, x.weights.tolist(), strict=True))
    return {
        "nipples_in_front": float(nipple[2] - end[2]) / bone,
        "nipples_over_folds": float(nipple[1] - fold[1]) / bone,
        "length": float(np.linalg.norm(nipple - fold)) / bone,
        **_facing_back((target.vertices @ axes - end) / bone, target),
        **{sign: weights[f"{shape}_{side}"] for sign, shape in SHAPES.items() if f"{shape}_{side}" in weights},
    }


def _facing_back(vertices: Array, target: ScanTarget) -> dict[str, float]:
    """Share of the trunk's scanned skin; (V, 3) from the xiphoid in the body's axes, in lengths of the breastbone.

    Nothing where a program has closed the surface.
    """
    faces = target.faces
    crosses, middles = face_crosses(vertices, faces), vertices[faces].mean(axis=1)
    (low, high), aside = TRUNK
    trunk = (middles[:, 1] > low) & (middles[:, 1] < high) & (np.abs(middles[:, 0]) < aside)
    areas = np.linalg.norm(crosses, axis=1)
    backwards = trunk & (crosses[:, 2] < BACKWARDS * areas)
    share = float(areas[backwards].sum() / max(areas[trunk].sum(), 1e-9))
    return {"facing_back": share} if target.on_border.any() else {}


def measured_signs(task: FitTask, standing: FitIterate) -> dict[str, float]:
    """What the end of a task's fit as standing shows, by the signs' names."""
    rig, x = task.rig, standing.parameters
    vertices = pose(rig, x)
    seen = breast_signs(rig, x, vertices, task.target)
    arms = arm_angles(rig, x)
    if len(arms):
        seen["arms"] = float(arms.mean())
    _, up, front = body_axes(rig, vertices).T @ SCANNERS_UP
    seen["upright"] = float(up > UPRIGHT) - float(front > UPRIGHT)
    return seen


def likely_stance(seen: Mapping[str, float]) -> LikelyStance:
    signs = stance_signs()
    odds = signs.log_odds(seen)
    return LikelyStance(odds > 0.0, abs(odds) > signs.unsure)
