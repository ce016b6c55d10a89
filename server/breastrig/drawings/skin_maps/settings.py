"""How skin is expected to move between two stances, as data: one file for each rig, the reasons beside the numbers."""

import tomllib
from functools import lru_cache
from importlib import resources
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Count = Annotated[int, Field(ge=1)]

FALLBACK = "torso"  # for rigs without a file of their own


class SkinMapSettings(BaseModel):
    """Of drawings/skin_map.py; lengths in m, angles in rad."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    centres: Count
    length: Positive
    displacement: Positive
    strain: Positive
    shift_length: Positive
    landmark_error: Positive
    model_error: Positive
    model_points: Count
    surface_error: Positive
    surface_scale: Positive
    on_scan_distance: Positive
    on_scan_angle: Positive
    to_scan_distance: Positive
    to_scan_angle: Positive
    rounds: Count
    reach: Positive
    error_share: NotNegative
    error_skin: Positive


@lru_cache(maxsize=8)
def skin_map_settings(rig: str) -> SkinMapSettings:
    """For the rig of this name."""
    folder = resources.files("breastrig.drawings.skin_maps")
    names = {file.name for file in folder.iterdir()}
    file = f"{rig}.toml" if f"{rig}.toml" in names else f"{FALLBACK}.toml"
    return SkinMapSettings.model_validate(tomllib.loads((folder / file).read_text("utf-8")))
