"""Numbers of patterns as people write them: decimal comma and point alike, an hour of the clock as a time (10:30).

The page's fields have the same rules (web/src/ui/NumberField.ts).
"""

import re
from typing import Literal, get_origin

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator

CLOCK = "clock"  # the parameter that is an hour
TIME = re.compile(r"(\d{1,2})[:h]([0-5]\d)")
THOUSANDS = re.compile(r"[-+]?[1-9]\d{0,2},\d{3}")
UNIT = re.compile(r"\s*(mm|°|o'clock)$")


class WrittenNumbers(BaseModel):
    """Parameters whose numbers may be given as text."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    @field_validator("*", mode="before")
    @classmethod
    def _read(cls, value: object, info: ValidationInfo) -> object:
        name = str(info.field_name)
        if not isinstance(value, str) or get_origin(cls.model_fields[name].annotation) is Literal:
            return value
        return read_number(value, name == CLOCK)


class OnBreasts(WrittenNumbers):
    """A pattern drawn on one breast or on both."""

    side: Literal["both", "L", "R"] = Field("both", title="Side", description="the patient's side")


class AroundAreola(OnBreasts):
    """A pattern with a new areola."""

    areola_mm: float = Field(
        42.0, title="New areola", ge=30.0, le=55.0, description="diameter of the new areola; 40 to 45 is usual"
    )


def read_number(written: str, is_hour: bool = False) -> float:
    """The number; ValueError with what is wrong where it is none, or may be read in two ways."""
    text = UNIT.sub("", written.strip().replace("\u2212", "-")).replace("½", ".5")
    time = TIME.fullmatch(text) if is_hour else None
    if time is not None:
        return round(int(time[1]) + int(time[2]) / 60.0, 2)
    if len(re.findall("[.,]", text)) > 1 or THOUSANDS.fullmatch(text):
        raise ValueError("it can be read in two ways; write one comma or point, for the decimals")
    try:
        return float(text.replace(",", "."))
    except ValueError as error:
        form = "an hour, for instance 10:30 or 10.5" if is_hour else "a number, for instance 4.5 or 4,5"
        raise ValueError(f"write {form}") from error


def split_parameters(values: str) -> list[str]:
    """`areola_mm=42,5,limb_mm=50` at the commas between parameters: digits after a number with a name are its decimals.

    Where names are left out, every comma stands between two parameters.
    """
    parts: list[str] = []
    for word in (each.strip() for each in values.split(",")):
        if parts and re.match(r"\d+\b", word) and re.fullmatch(r"\w+\s*=\s*[-+]?\d[\d.,]*", parts[-1]):
            parts[-1] += f",{word}"
        else:
            parts.append(word)
    return [part for part in parts if part]
