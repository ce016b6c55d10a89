"""Numbers kept as data with their reasons beside them: what checks them, and how the package's own are read."""

import tomllib
from importlib import resources
from typing import Annotated, TypeVar

from pydantic import BaseModel, ConfigDict, Field

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]


class SettingsPart(BaseModel):
    """A table of a settings file: no other words than its own."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)


Settings = TypeVar("Settings", bound=SettingsPart)


def packaged(kind: type[Settings], package: str, file: str) -> Settings:
    """A TOML file that comes with this package of BreastRig."""
    return kind.model_validate(tomllib.loads((resources.files(package) / file).read_text("utf-8")))
