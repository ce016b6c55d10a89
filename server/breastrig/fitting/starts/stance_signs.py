"""The likely stance of a body without a visible table, from the signs of a fit as standing.

Breasts that hang far in front of the chest on a skin no higher than an MRI's field of view are prone. For the other
stances arms show little: standing ones may be anywhere. Breasts show most, by the one that is more in front, as the
other may be gone: the place of the nipple relative to breastbone and fold, in units of the breastbone's length, and the
shapes by which breasts flatten and lie aside. Skin that faces backwards is seen of a standing body only. All counts in
proportion to the breast's length, for small ones lie as they stand. Weights: stance_signs.toml, by
breastrig_studies/stance_signs.py; docs/decisions/0022.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from breastrig.core.arrays import Array, lengths
from breastrig.core.settings_file import SettingsPart, packaged
from breastrig.core.stances import PRONE, SIDES, STANDING, SUPINE
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.geometry.normals import face_crosses
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.similarity import body_axes
from breastrig.rig.skinning import pose

MEASURED = ("suprasternal_notch", "xiphoid", "nipple_L", "nipple_R", "inframammary_fold_L", "inframammary_fold_R")
SHAPES = {"flattened": "projection", "aside": "position_lateral"}  # signs that are weights of a shape
BACKWARDS = -0.3  # cosine to the front; a lying body is seen from above
# In lengths of the breastbone: heights over the xiphoid, and how far to the sides, between which no arm is
TRUNK = ((-0.5, 0.75), 0.8)
CLEFT = (0.01, 0.03)  # m: half the width and length of the skin between the nipples
SCANNERS_UP = np.array([0.0, 1.0, 0.0])  # as scan/orient.py has it
UPRIGHT = np.cos(np.radians(15.0))  # people lean, and apps level to a few degrees


class Sign(SettingsPart):
    between: float  # its value that says nothing
    weight: float  # of the log odds, for one unit more
    most: float  # farther from `between` it counts no more
    by_hand: bool = False  # not estimated: simulated scans are turned at random

    def counted(self, value: float) -> float:
        return self.weight * float(np.clip(value - self.between, -self.most, self.most))


class StanceLogOdds(SettingsPart):
    """Log odds of a stance against standing, from signs."""

    constant: float  # log odds where no sign says anything
    length: float | None = None  # of the breast by which signs are measured; what is seen of a shorter one says less
    signs: dict[str, Sign]

    def log_odds(self, seen: Mapping[str, float]) -> float:
        """The log odds; signs that were not seen are left out."""
        counted = self.constant + sum(each.counted(seen[name]) for name, each in self.signs.items() if name in seen)
        return counted if self.length is None else counted * seen.get("length", self.length) / self.length


class StanceSigns(SettingsPart):
    """The contents of stance_signs.toml."""

    unsure: float  # log odds of the likeliest stance against the next up to which the answer is doubted
    supine: StanceLogOdds
    prone: StanceLogOdds


@dataclass(frozen=True)
class LikelyStance:
    """The most likely stance, and whether the signs are clear."""

    stance: str
    sure: bool


@lru_cache(maxsize=1)
def stance_signs() -> StanceSigns:
    return packaged(StanceSigns, "breastrig.fitting.starts", "stance_signs.toml")


def likely_stance(seen: Mapping[str, float], known: StanceSigns | None = None) -> LikelyStance:
    """The likely stance by the package's own numbers, or others."""
    known = known or stance_signs()
    odds = {STANDING: 0.0, SUPINE: known.supine.log_odds(seen), PRONE: known.prone.log_odds(seen)}
    first, second, _ = sorted(odds, key=lambda stance: -odds[stance])
    return LikelyStance(first, odds[first] - odds[second] > known.unsure)


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
    """The signs of the breasts in (V, 3) m vertices, posed by `x`, in lengths of the breastbone.

    Empty for a rig without its landmarks.
    """
    if not set(MEASURED) <= set(rig.landmark_names):
        return {}
    axes = body_axes(rig, vertices)
    notch, end, *breasts = rig.landmark_points(MEASURED).positions(vertices, rig.faces) @ axes
    away = target.vertices @ axes - 0.5 * (breasts[0] + breasts[1])
    narrow = (np.abs(away[:, 0]) < CLEFT[0]) & (np.abs(away[:, 1]) < CLEFT[1])
    between = away[narrow & (target.normals @ axes[:, 2] > 0.0), 2]
    side, nipple, fold = max(zip(SIDES, breasts[:2], breasts[2:], strict=True), key=lambda each: float(each[1][2]))
    bone = float(np.linalg.norm(notch - end))
    weights = dict(zip(rig.shape_names, x.weights.tolist(), strict=True))
    return {
        "nipples_in_front": float(nipple[2] - end[2]) / bone,
        "nipples_over_folds": float(nipple[1] - fold[1]) / bone,
        "length": float(np.linalg.norm(nipple - fold)) / bone,
        **({"cleft": -float(np.quantile(between, 0.1))} if len(between) else {}),
        **_facing_back((target.vertices @ axes - end) / bone, target),
        **{sign: weights[f"{shape}_{side}"] for sign, shape in SHAPES.items() if f"{shape}_{side}" in weights},
    }


def _facing_back(vertices: Array, target: ScanTarget) -> dict[str, float]:
    """Share of the trunk's scanned skin; (V, 3) from the xiphoid in the body's axes, in lengths of the breastbone.

    Nothing where a program has closed the surface.
    """
    faces = target.faces
    crosses = face_crosses(vertices, faces)
    middles = sum(vertices.take(corner, axis=0) for corner in faces.T) / 3.0
    (low, high), aside = TRUNK
    trunk = (middles[:, 1] > low) & (middles[:, 1] < high) & (np.abs(middles[:, 0]) < aside)
    areas = lengths(crosses)
    backwards = trunk & (crosses[:, 2] < BACKWARDS * areas)
    share = float(areas[backwards].sum() / max(areas[trunk].sum(), 1e-9))
    return {"facing_back": share} if target.on_border.any() else {}


def measured_signs(task: FitTask, standing: FitIterate) -> dict[str, float]:
    """The signs at the end of a task's fit as standing, by their names."""
    rig, x = task.rig, standing.parameters
    vertices = pose(rig, x)
    seen = breast_signs(rig, x, vertices, task.target)
    arms = arm_angles(rig, x)
    if len(arms):
        seen["arms"] = float(arms.mean())
    axes = body_axes(rig, vertices)
    _, up, front = axes.T @ SCANNERS_UP
    seen["upright"] = float(up > UPRIGHT) - float(front > UPRIGHT)
    heights = task.target.vertices @ axes[:, 1]
    seen["height"] = float(np.ptp(np.percentile(heights, [1.0, 99.0]))) if len(heights) else 0.0
    return seen
