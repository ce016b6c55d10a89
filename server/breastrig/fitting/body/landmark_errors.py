"""Offsets of bodies' landmarks from the model's: mean and standard deviation of each, data beside the rig.

In the body's axes (outwards, up, front), around the landmark of a fit without a pick of it. Estimated on patients whose
landmarks are known (breastrig_studies/landmark_errors.py); docs/decisions/0028.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from pydantic import Field, FiniteFloat

from breastrig.core.arrays import Array
from breastrig.core.settings_file import NotNegative, SettingsPart
from breastrig.core.stances import STANDING, split_side
from breastrig.fitting.body.hanging import outwards
from breastrig.relief.limits import relief
from breastrig.rig.known import known_part
from breastrig.rig.model import Rig
from breastrig.rig.similarity import body_axes
from breastrig.rig.state import BodyState

FILE, SCHEMA = "landmark_errors.json", "breastrig/landmark-errors@1"
UNKNOWN = 5.0  # mm on each axis, of rigs of which nothing is known


class LandmarkError(SettingsPart):
    """The offset of one landmark, left and right alike."""

    mean_mm: tuple[FiniteFloat, FiniteFloat, FiniteFloat] = (0.0, 0.0, 0.0)  # outwards, up, front
    deviation_mm: tuple[NotNegative, NotNegative, NotNegative] = (UNKNOWN, UNKNOWN, UNKNOWN)


class _File(SettingsPart):
    schema_: Literal["breastrig/landmark-errors@1"] = Field(alias="schema")
    stances: dict[str, dict[str, LandmarkError]]


@lru_cache(maxsize=8)
def landmark_errors(rig: Rig, stance: str) -> dict[str, LandmarkError]:
    """Offsets by the names of landmarks without their sides; a stance without its own has those of standing bodies."""
    known = known_part(rig, FILE, _File)
    return {} if known is None else known.stances.get(stance, known.stances.get(STANDING, {}))


@dataclass(frozen=True, eq=False)
class ExpectedGap:
    """The expected gap from the model's landmark to the body's, in the scan's frame."""

    mean: Array  # (3,) m
    covariance: Array  # (3, 3) m²


def expected_gaps(state: BodyState, stance: str) -> dict[str, ExpectedGap]:
    """The expected gaps of all landmarks of the rig."""
    known, found = landmark_errors(state.rig, stance), {}
    axes = body_axes(state.rig, state.vertices) if known else np.eye(3)  # a rig may have too few landmarks for any
    for name in state.rig.landmark_names:
        error, own = known.get(split_side(name)[0], LandmarkError()), axes * outwards(name)
        spread = own * (1e-3 * np.array(error.deviation_mm))
        found[name] = ExpectedGap(own @ (1e-3 * np.array(error.mean_mm)), spread @ spread.T)
    return found


NOTCH, XIPHOID, MIDDLE = "suprasternal_notch", "xiphoid", "mid_sternum"


def middle_step(places: Mapping[str, Array]) -> Array:
    """(3,) m along the breastbone, from where a model has its middle to where it is expected between its ends.

    places: (3,) m by name, of these three; nothing when the two ends are one place.
    """
    rules, bone = relief().mid_sternum, places[XIPHOID] - places[NOTCH]
    length = float(bone @ bone)
    at = float((places[MIDDLE] - places[NOTCH]) @ bone) / length if length > 0.0 else rules.at
    return np.asarray(rules.share * (rules.at - at) * bone)
