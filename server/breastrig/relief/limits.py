"""Numbers that distinguish concavities from the skin around them; each has its reason beside it in features.toml."""

from functools import lru_cache
from typing import Annotated, Literal

from pydantic import Field

from breastrig.core.settings_file import NotNegative, Positive, SettingsPart, packaged
from breastrig.core.stances import split_side


class Smooth(SettingsPart):
    """Limits of skin without a visible concavity."""

    around: Positive  # m, of a place
    below: Positive  # logarithm of a chance, as `weight` and `most` make it


class Concavity(SettingsPart):
    """A kind of concavity with a landmark in it."""

    view: Literal["skin", "front"]  # along the skin's own normal around, or from the body's front
    around: Positive  # m, of whose skin the normal is the mean
    scale: Positive  # m, of the Gaussian
    across: NotNegative  # weights of the curvatures of the two cuts through the skin
    along: NotNegative
    weight: Positive  # m, of one unit of curvature in the logarithm of a chance
    most: Positive  # 1/m; more says no more
    aside: Positive  # m, on each axis, error of the form's place to the side and up
    up: Positive
    shows_side: bool  # whether it is a dent; a fold says nothing of where along it the landmark lies
    least_gain: Annotated[float, Field(gt=0.0, lt=1.0)]  # share of the form's error up that must go
    error_scale: Positive  # times the standard deviation of the chances
    floor: Positive  # m, error on each axis of the skin that the chances do not show
    depth: Positive  # m, error along the skin's normal
    reason: str  # a few words
    smooth: Smooth | None = None  # absent: nobody knows


class Shoulder(SettingsPart):
    """The position of a hanging shoulder's tip relative to the form of the arm below it."""

    edge_below: Positive  # m, under the tip
    edge_beyond: Positive  # m, of the arm's outer edge there, outwards from the tip
    front_below: Positive  # m, under the tip
    front_before: Positive  # m, of the arm's front there, from the tip
    strip: Positive  # m, to either side, whose highest or foremost place is taken
    reach: Positive  # m, around the form's tip, of the shoulder that is looked at
    farthest: Positive  # m, from the form's tip
    shown: Positive  # m, to the nearest vertex of the scan at edge and front
    errors: tuple[Positive, Positive, Positive]  # m, outwards, up, front
    where_hanging: Positive  # times these errors where breasts hang
    reason: str  # a few words


class MidSternum(SettingsPart):
    """The expected middle of the sternum between its ends."""

    at: Annotated[float, Field(gt=0.0, lt=1.0)]  # share of the way from notch to xiphoid
    share: Annotated[float, Field(ge=0.0, le=1.0)]  # of the step there from the model's own place


class Relief(SettingsPart):
    """The contents of features.toml."""

    pixel: Positive  # m
    fine: Positive  # m, scale at which the skin's height is read where the landmark is
    reach: Positive  # times the form's error, how far is looked
    shoulder: Shoulder
    mid_sternum: MidSternum
    concavities: dict[str, Concavity]  # by the landmark's name without its side

    def concavity(self, landmark: str) -> Concavity | None:
        """The landmark's concavity; None where it lies in none."""
        return self.concavities.get(split_side(landmark)[0])


@lru_cache(maxsize=1)
def relief() -> Relief:
    """The package's own settings (features.toml), read once."""
    return packaged(Relief, "breastrig.relief", "features.toml")
