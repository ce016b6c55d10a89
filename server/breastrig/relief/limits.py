"""Numbers by which hollows are told from the skin around them; each has its reason beside it in features.toml."""

import tomllib
from functools import lru_cache
from importlib import resources
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Hollow(_Part):
    """One kind of hollow that a landmark lies in."""

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


class Relief(_Part):
    """All of features.toml."""

    pixel: Positive  # m
    fine: Positive  # m, scale at which the skin's height is read where the landmark is
    reach: Positive  # times the form's error, how far is looked
    hollows: dict[str, Hollow]  # by the landmark's name without its side


@lru_cache(maxsize=1)
def relief() -> Relief:
    """The package's own."""
    file = resources.files("breastrig.relief") / "features.toml"
    return Relief.model_validate(tomllib.loads(file.read_text("utf-8")))
