"""How likely a body lies whose scan shows no table: four signs that a fit as if she stood shows, weighed together.

Arms lie away from who lies and hang beside who stands, but a woman may lay them along her sides.  Her breasts say it
then: they flatten and fall aside, so that nipples lie less far in front of the breastbone's end and farther from each
other, measured by her breastbone.  That lying breasts are shown with less energy by the shapes of lying ones is the
weakest sign, and its outliers are cut off.  The numbers are beside this file; see breastrig_studies/stance_signs.py.

Wrong answers, and of these those that are not said to be unsure, of warped bodies without their tables; before:
arms and energy alone, and no word of doubt.  In the choosing half each source by the others:

                                       choosing half                  reporting half
                               scans  before  wrong  sure      scans  before  wrong  sure
    as usual        standing      50       3      0     0         49       2      1     0
                    lying         50       4      0     0         45       5      3     2
      left half     standing      43       9      3     2         42       6      0     0
                    lying         40       2      1     0         27       4      5     0
    arms away       standing      50      42     35    19         49      36     22    11
    arms along      lying         50      15     11     3         46      13     15     5
      left halves   standing      43      36     25    12         43      27     15     4
                    lying         43      16     21     7         31      12     23     4

Tried: how the fold lies below the breastbone's end, how breasts face and the shape weights of the fit tell our bodies
apart still better, but put dev scans on the wrong side.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources

import numpy as np
from pydantic import BaseModel, ConfigDict

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.body.hanging import body_axes
from breastrig.fitting.body.hollows import energy_without_hollows
from breastrig.fitting.task import FitIterate, FitTask
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters
from breastrig.rig.skinning import pose

MEASURED = ("suprasternal_notch", "xiphoid", "nipple_L", "nipple_R")
SHOWN = 0.015  # m from the scan


class Sign(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)
    between: float  # its value that says nothing
    weight: float  # of the log odds that she lies, for one unit more
    most: float | None = None  # farther from `between` it counts no more


class StanceSigns(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)
    unsure: float  # log odds, either way, up to which the answer is doubted
    signs: dict[str, Sign]

    def log_odds(self, seen: Mapping[str, float]) -> float:
        """That she lies; what was not seen says nothing."""
        return sum(self._counted(name, value) for name, value in seen.items())

    def _counted(self, name: str, value: float) -> float:
        sign, away = self.signs[name], value - self.signs[name].between
        return sign.weight * (away if sign.most is None else float(np.clip(away, -sign.most, sign.most)))


@dataclass(frozen=True)
class Likely:
    """Which stance the signs speak for, and whether they do so clearly."""

    lies: bool
    sure: bool


@lru_cache(maxsize=1)
def stance_signs() -> StanceSigns:
    file = resources.files("breastrig.fitting") / "starts" / "stance_signs.toml"
    return StanceSigns.model_validate(tomllib.loads(file.read_text("utf-8")))


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


def seen_signs(task: FitTask, standing: FitIterate, supine: FitIterate | None = None) -> dict[str, float]:
    """What the ends of a task's fits in both stances show, by the signs' names; of one fit no energy."""
    seen = breast_signs(task.rig, pose(task.rig, standing.parameters), task.target)
    arms = arm_angles(task.rig, standing.parameters)
    if len(arms):
        seen["arms"] = float(arms.mean())
    if supine is not None:
        seen["energy_less"] = energy_without_hollows(task, standing) - energy_without_hollows(task, supine)
    return seen


def likely_stance(seen: Mapping[str, float]) -> Likely:
    signs = stance_signs()
    odds = signs.log_odds(seen)
    return Likely(odds > 0.0, abs(odds) > signs.unsure)
