"""The patterns' parameters as data, for those who offer them as sliders and choices.

All of it is read from the classes that check the values, so what is offered and what is taken cannot differ.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

from pydantic import BaseModel

from breastrig.drawings.patterns import LABELS, PATTERNS, able_patterns
from breastrig.rig.model import Rig

UNITS = {"mm": "mm", "deg": "deg", "clock": "h"}  # by the last word of a parameter's name


@dataclass(frozen=True)
class Parameter:
    name: str
    label: str
    about: str
    unit: str  # mm, deg, h, or nothing
    default: float | str | None
    needed: bool
    min: float | None
    max: float | None
    choices: tuple[str, ...] | None


@dataclass(frozen=True)
class PatternForm:
    name: str
    label: str
    parameters: tuple[Parameter, ...]


def pattern_forms(rig: Rig) -> tuple[PatternForm, ...]:
    """What can be asked for on this rig."""
    return tuple(PatternForm(name, LABELS[name], _parameters(name)) for name in able_patterns(rig))


def _parameters(name: str) -> tuple[Parameter, ...]:
    return tuple(parameters_of(PATTERNS[name]).values())


@cache
def parameters_of(kind: type[BaseModel]) -> dict[str, Parameter]:
    """The parameters of a class of patterns, by name; reading them from its schema takes some milliseconds."""
    schema = kind.model_json_schema()
    return {
        word: _parameter(word, shape, word in schema.get("required", ()))
        for word, shape in schema["properties"].items()
    }


def _parameter(name: str, shape: dict[str, Any], needed: bool) -> Parameter:
    kind = next((one for one in shape.get("anyOf", ()) if one.get("type") != "null"), shape)
    return Parameter(
        name=name,
        label=shape["title"],
        about=shape["description"],
        unit=UNITS.get(name.rsplit("_", 1)[-1], ""),
        default=shape.get("default"),
        needed=needed,
        min=kind.get("minimum"),
        max=kind.get("maximum"),
        choices=tuple(kind["enum"]) if "enum" in kind else None,
    )
