"""What a posterior does not know: how far real bodies are from what the model can show, kept as data beside the rig.

A radius is a factor times the root of the posterior's variance and of a misfit's, which no pick elsewhere changes.  The
factor is so chosen for each kind of place that it holds nine of ten true places of women who are known, each woman
counting alike (conformal prediction normalised by a model's own deviation: Lei et al., Distribution-free predictive
inference for regression, 2018).  Factor and misfit are the same however much was picked, so that what makes the
posterior surer makes the radius smaller.  Written by breastrig_studies/radii_factors.py; docs/decisions/0025.
"""

from functools import lru_cache
from typing import NamedTuple

from pydantic import Field

from breastrig.core.errors import BadModel
from breastrig.core.settings_file import NotNegative, Positive, SettingsPart
from breastrig.core.stances import STANDING, split_side
from breastrig.rig.known import checked_part, known_numbers
from breastrig.rig.model import Rig

SCHEMA = "breastrig/radii@2"
Factors = dict[str, Positive]  # by kind: of landmarks without their side, of regions likewise; "other" for the rest
Misfits = dict[str, NotNegative]  # mm, likewise


class StanceFactors(SettingsPart):
    """Of bodies in one stance."""

    given: Factors = Field(default={})  # landmarks that were given
    others: Factors = Field(default={})  # those that were not
    proposed: Factors = Field(default={})  # of a fit without any, around where they are expected (landmark_errors.py)
    seen: Factors = Field(default={})  # skin that the scan shows
    hidden: Factors = Field(default={})  # skin that it does not show
    hanging: Factors = Field(default={})  # times more where a breast hangs, of landmarks and regions
    misfit_mm: dict[str, Misfits] = Field(default={})  # root mean square, by "others", "seen", "hidden"; absent: none

    def misfit(self, state: str, name: str) -> float:
        """m, root mean square error of a landmark or region by its name that the posterior does not know."""
        return 1e-3 * _of(self.misfit_mm.get(state, {}), name, 0.0)


class Scatter(NamedTuple):
    """How far picks are from where all else has them."""

    deviation: float  # root mean square on an axis, in the units of picks as good as is said
    picks: int


NO_PICKS = Scatter(1.0, 0)


class WithoutPicks(SettingsPart):
    """Of a fit that the scan alone has placed; see Start.margin for how clear that was."""

    clear: Positive  # margin from which the body lies as it was found
    unclear: Positive  # and up to which it lies another way, as nearly all did
    astray: Positive  # m, root mean square distance of every place, where it does

    def lost(self, margin: float) -> float:
        """m, root mean square distance for the chance that the body lies another way."""
        return self.astray * min(max((self.clear - margin) / (self.clear - self.unclear), 0.0), 1.0)


class Calibration(SettingsPart):
    """Of one model."""

    usual_scatter: Positive  # of picks as good as is said, see radii.py
    freedom_given: Positive  # how many residuals the usual scatter counts as, for radii of what was given
    freedom_elsewhere: Positive  # and for all others
    without_picks: WithoutPicks
    stances: dict[str, StanceFactors] = Field(default={})

    def enlarged(self, scatter: Scatter, *, given: bool) -> float:
        """By how much picks that scatter so enlarge the posterior's deviations of what was `given`, or of all else.

        The posterior mean of a variance that is expected to be the usual one (an inverse chi square): few picks say
        little, each more says more.
        """
        expected, found = self.freedom_given if given else self.freedom_elsewhere, 2 * scatter.picks  # axes of the skin
        square = (scatter.deviation / self.usual_scatter) ** 2
        return float(((expected + found * square) / (expected + found)) ** 0.5)

    def of_stance(self, stance: str) -> StanceFactors:
        """Those of this stance; what nobody has measured in it, as standing."""
        standing, its = self.stances.get(STANDING, StanceFactors()), self.stances.get(stance, StanceFactors())
        misfits = standing.misfit_mm | its.misfit_mm
        return standing.model_copy(update={name: group for name, group in its if group} | {"misfit_mm": misfits})


def factor_of(factors: Factors, name: str) -> float:
    """Of a landmark or region by its name; 1 where there is none for it nor for others."""
    return _of(factors, name, 1.0)


def _of(numbers: dict[str, float], name: str, without: float) -> float:
    return numbers.get(split_side(name)[0], numbers.get("other", without))


@lru_cache(maxsize=8)
def calibration(rig: Rig) -> Calibration | None:
    """Of this rig; None when nobody has found any."""
    known, factors = known_numbers(rig, "uncertainty.toml"), known_numbers(rig, "radii.json")
    if known is None or factors is None:
        return None
    if factors.get("schema", SCHEMA) != SCHEMA:
        raise BadModel(f"{rig.name}.known/radii.json is no {SCHEMA}; have it learned anew (breastrig model learn).")
    return checked_part(rig, "uncertainty.toml", Calibration, known | {"stances": factors.get("stances", {})})
