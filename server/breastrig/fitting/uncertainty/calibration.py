"""Errors that a posterior lacks, the distance of real bodies from what the model can show: data beside the rig.

A radius is the posterior's standard deviation times a factor, chosen for each kind of place such that it holds nine of
ten true places of known patients, each patient counting alike (conformal prediction normalised by a model's own
deviation: Lei et al., Distribution-free predictive inference for regression, 2018). Written by
breastrig_studies/radii_factors.py; docs/decisions/0025.
"""

from functools import lru_cache
from typing import NamedTuple

from pydantic import Field

from breastrig.core.settings_file import Positive, SettingsPart
from breastrig.core.stances import STANDING, split_side
from breastrig.rig.known import checked_part, known_numbers
from breastrig.rig.model import Rig

Factors = dict[str, Positive]  # by kind: of landmarks without their side, of regions likewise; "other" for the rest


class StanceFactors(SettingsPart):
    """Factors for bodies in one stance."""

    given: Factors = Field(default={})  # landmarks that were given
    others: Factors = Field(default={})  # those that were not, beside given ones
    alone: Factors = Field(default={})  # all landmarks of a fit without any
    proposed: Factors = Field(default={})  # the same around where they are expected (body/landmark_errors.py)
    seen: Factors = Field(default={})  # skin that the scan shows, with landmarks given
    hidden: Factors = Field(default={})  # skin that it does not show
    seen_alone: Factors = Field(default={})  # likewise without any landmark
    hidden_alone: Factors = Field(default={})
    hanging: Factors = Field(default={})  # times more where a breast hangs, of landmarks and regions


class Scatter(NamedTuple):
    """The picks' deviations from everything else."""

    deviation: float  # root mean square on an axis, in the units of picks as good as is said
    picks: int


NO_PICKS = Scatter(1.0, 0)


class WithoutPicks(SettingsPart):
    """Errors of a fit placed by the scan alone; see Start.margin for the clarity of its start."""

    clear: Positive  # margin from which the body lies as it was found
    unclear: Positive  # and up to which it lies another way, as nearly all did
    astray: Positive  # m, root mean square distance of every place, where it does

    def lost(self, margin: float) -> float:
        """m, root mean square distance for the chance that the body lies another way."""
        return self.astray * min(max((self.clear - margin) / (self.clear - self.unclear), 0.0), 1.0)


class Calibration(SettingsPart):
    """The calibration of one model."""

    expected_scatter: Positive  # before any pick is known, see radii.py
    freedom_given: Positive  # how many residuals that expectation counts as, for radii of what was given
    freedom_elsewhere: Positive  # and for all others
    without_picks: WithoutPicks
    stances: dict[str, StanceFactors] = Field(default={})

    def enlarged(self, scatter: Scatter, *, given: bool) -> float:
        """The factor of radii for this scatter of the picks, of `given` landmarks or of all else; 1 without picks.

        The root of the posterior mean of a variance (an inverse chi square): few picks say little, each more says more.
        """
        expected, found = self.freedom_given if given else self.freedom_elsewhere, 2 * scatter.picks  # axes of the skin
        square = (scatter.deviation / self.expected_scatter) ** 2
        return float(((expected + found * square) / (expected + found)) ** 0.5)

    def of_stance(self, stance: str) -> StanceFactors:
        """The factors of this stance; those that are not measured in it are of standing bodies."""
        standing, its = self.stances.get(STANDING, StanceFactors()), self.stances.get(stance, StanceFactors())
        return standing.model_copy(update={name: group for name, group in its if group})


def factor_of(factors: Factors, name: str) -> float:
    """The factor of a landmark or region by its name, else that of others, else 1."""
    return factors.get(split_side(name)[0], factors.get("other", 1.0))


@lru_cache(maxsize=8)
def calibration(rig: Rig) -> Calibration | None:
    """This rig's calibration; None when it has none."""
    known, factors = known_numbers(rig, "uncertainty.toml"), known_numbers(rig, "radii.json")
    if known is None or factors is None:
        return None
    return checked_part(rig, "uncertainty.toml", Calibration, known | {"stances": factors.get("stances", {})})
