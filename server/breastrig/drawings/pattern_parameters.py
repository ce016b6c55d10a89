"""The patterns' parameters as data, for forms with sliders and choices.

All of it is read from the classes that check the values, so the offered and the accepted values cannot differ.
"""

from functools import cache
from typing import Any, Literal

from pydantic import BaseModel, Field

from breastrig.drawings.patterns import LABELS, PATTERNS, able_patterns
from breastrig.rig.model import Rig

Unit = Literal["mm", "deg", "h", ""]
UNITS: dict[str, Unit] = {"mm": "mm", "deg": "deg", "clock": "h"}  # by the last word of a parameter's name


class PatternParameter(BaseModel, extra="forbid", frozen=True):
    """A parameter: a number, or a choice."""

    name: str
    label: str
    about: str = Field(description="one sentence for people")
    unit: Unit
    default: float | str | None = Field(description="null: must be given, or when `needed` is false chosen by itself")
    needed: bool = Field(description="whether it must be given")
    min: float | None = Field(description="null for a choice and for a place")
    max: float | None
    choices: tuple[str, ...] | None


class PatternInfo(BaseModel, extra="forbid", frozen=True):
    """A drawing made from numbers: asked for as `name:parameter=value,parameter=value`."""

    name: str
    label: str
    parameters: tuple[PatternParameter, ...]


def pattern_forms(rig: Rig) -> list[PatternInfo]:
    """The patterns available on this rig, with their parameters."""
    return [
        PatternInfo(name=name, label=LABELS[name], parameters=tuple(parameters_of(PATTERNS[name]).values()))
        for name in able_patterns(rig)
    ]


@cache
def parameters_of(kind: type[BaseModel]) -> dict[str, PatternParameter]:
    """The parameters of a class of patterns, by name; reading them from its schema takes some milliseconds."""
    schema = kind.model_json_schema()
    return {
        word: _parameter(word, shape, word in schema.get("required", ()))
        for word, shape in schema["properties"].items()
    }


def _parameter(name: str, shape: dict[str, Any], needed: bool) -> PatternParameter:
    kind = next((one for one in shape.get("anyOf", ()) if one.get("type") != "null"), shape)
    return PatternParameter(
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
