"""Settings in TOML: numbers with their reasons beside them, and files of those who run a service."""

import tomllib
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from breastrig.core.errors import BadSettings

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]


class SettingsPart(BaseModel):
    """A table of a settings file: no other words than its own."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)


Settings = TypeVar("Settings", bound=SettingsPart)


def packaged(kind: type[Settings], package: str, file: str) -> Settings:
    """A TOML file that comes with this package of BreastRig."""
    return kind.model_validate(tomllib.loads((resources.files(package) / file).read_text("utf-8")))


def read_toml(file: Path, what: str, hint: str) -> dict[str, Any]:
    """A file of whoever runs the service.  Raises BadSettings: the `what` file, and what to do where it is no TOML."""
    try:
        return tomllib.loads(file.read_bytes().decode())
    except OSError as error:
        raise BadSettings(f"The {what} file {file} cannot be read ({error.strerror}).") from error
    except ValueError as error:
        raise BadSettings(f"The {what} file {file} is not TOML; {hint}.") from error


def checked(kind: type[Settings], content: dict[str, Any], what: str) -> Settings:
    """The settings; BadSettings with one sentence, which begins with `what`, on the first fault and on no content."""
    try:
        return kind.model_validate(content)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(map(str, first["loc"]))
        said = first["msg"].removeprefix("Value error, ")
        raise BadSettings(f"{what}: {where and f'{where}: '}{said}.") from None
