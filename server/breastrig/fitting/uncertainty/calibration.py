"""What a posterior does not know: how far real bodies are from what the model can show, kept as data beside the rig.

The posterior (posterior.py) counts noise and priors.  Its standard deviations are stretched by a factor, and a misfit
is added to them, both chosen so that the radii hold nine of ten true places of bodies that are known.
"""

from functools import lru_cache

from breastrig.core.settings_file import NotNegative, Positive, SettingsPart
from breastrig.core.stances import split_side
from breastrig.rig.known import known_part
from breastrig.rig.model import Rig


class Misfit(SettingsPart):
    """m, root mean square distance, of one kind of place."""

    shown: NotNegative  # by a pick, or by the scan
    hidden: NotNegative  # by neither


class Hanging(SettingsPart):
    """m, root mean square distance that one unit of a hanging breast's shape adds, of a kind of landmark or region."""

    shown: NotNegative  # by a pick, or skin by the scan while there are picks
    hidden: NotNegative  # while others are picked
    without_picks: NotNegative


class WithoutPicks(SettingsPart):
    """Of a fit without landmarks, which the scan alone has placed; see Start.margin for how clear that was."""

    stretch: NotNegative  # of the posterior's standard deviations, in the place of that with picks
    clear: Positive  # margin from which the body lies as it was found
    unclear: NotNegative  # and up to which it lies another way, as nearly all did
    astray: Positive  # m, root mean square distance of every place, where it does
    landmarks: dict[str, NotNegative]  # m, root mean square distance, by name without its side; "other" for the rest

    def landmark(self, name: str) -> float:
        """m, of the landmark of this name."""
        return self.landmarks.get(split_side(name)[0], self.landmarks["other"])

    def lost(self, margin: float) -> float:
        """m, root mean square distance for the chance that the body lies another way."""
        return self.astray * min(max((self.clear - margin) / (self.clear - self.unclear), 0.0), 1.0)


class Calibration(SettingsPart):
    """Of one model."""

    stretch: NotNegative  # of the posterior's standard deviations
    usual_scatter: Positive  # of picks as good as is said, see radii.py
    least_scatter: Positive  # share of the radii that the best of picks leave
    least_scatter_hidden: Positive  # likewise where the scan shows no skin
    most_scatter: Positive  # and by how much the worst enlarge them
    landmarks: dict[str, Misfit]  # by name without its side; "other" for those that are not named
    regions: dict[str, Misfit]  # of the rig; "other" for vertices outside of all
    hanging: dict[str, Hanging]  # of landmarks, likewise, where breasts hang (body/hanging.py); absent: nothing
    hanging_regions: dict[str, Hanging]  # likewise of the rig's regions
    without_picks: WithoutPicks

    def landmark(self, name: str) -> Misfit:
        """Of the landmark of this name."""
        return self.landmarks.get(split_side(name)[0], self.landmarks["other"])

    def region(self, name: str) -> Misfit:
        """Of the region of this name."""
        return self.regions.get(split_side(name)[0], self.regions["other"])


@lru_cache(maxsize=8)
def calibration(rig: Rig) -> Calibration | None:
    """Of this rig; None when nobody has found any."""
    return known_part(rig, "uncertainty.toml", Calibration)
