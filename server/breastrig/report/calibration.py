"""Errors of measures by the model's outline, measured where the truth is known, kept as data beside the rig."""

from functools import lru_cache
from typing import Annotated

import numpy as np
from pydantic import Field

from breastrig.core.settings_file import NotNegative, SettingsPart
from breastrig.rig.known import known_part
from breastrig.rig.model import Rig

Share = Annotated[float, Field(ge=0.0, le=1.0)]


class Spread(SettingsPart):
    """An error (90 %) that grows with the radii of the places, but is never less than so much."""

    least: NotNegative  # m
    share: NotNegative  # of the radius

    def of(self, radius: float) -> float:
        """The error (m, 90 %) for a radius in m."""
        return float(np.hypot(self.least, self.share * radius))


class Outline(Spread):
    """The error of the outline that a fit transfers to a scan, in one stance."""

    outwards: float  # m, by which it lies too far in


class Heights(SettingsPart):
    """Errors of the heights of nipple, fold and lowest skin, along a standing body's axis."""

    picked: NotNegative  # m, 90 %, of a place that was picked
    lowest: NotNegative  # m, 90 %, of the lowest skin
    covered_below: float  # m of the nipple over the xiphoid, under which its breast covers the fold
    fold_over_xiphoid: float  # m, of a fold that nobody sees
    hidden_fold: NotNegative  # m, 90 %, of that


class Ends(SettingsPart):
    """Errors of the breast's lowest and most lateral skin along the body's axes, by the radii of that skin."""

    lateral: Spread  # across
    lowest: Spread  # in height


class Sides(SettingsPart):
    """Correlations of the errors of the left and of the right breast."""

    volume: Share
    base_width: Share
    lateral: Share  # of ends
    lowest: Share
    apart: dict[str, Share] = Field(default_factory=dict)  # by stance: bands.between_sides; 1 if not measured


class Stances(SettingsPart):
    """Correlations of the errors of two fits of one patient in two stances."""

    lengths: Share  # on one side, between two places of the model


class MeasureCalibration(SettingsPart):
    """The calibration of one rig's measures."""

    standing: Outline
    supine: Outline
    base_width: Spread
    heights: Heights
    ends: Ends
    sides: Sides
    stances: Stances

    def outline(self, stance: str) -> Outline:
        """The outline's error in a stance; every one but supine counts as standing."""
        return self.supine if stance == "supine" else self.standing


@lru_cache(maxsize=8)
def measure_calibration(rig: Rig) -> MeasureCalibration | None:
    """This rig's calibration; None when it has none."""
    return known_part(rig, "measures.toml", MeasureCalibration)
