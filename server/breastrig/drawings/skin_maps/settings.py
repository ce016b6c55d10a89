"""Settings of the skin's expected motion between two stances, as data with the reasons beside the numbers.

The common ones are beside this file; a rig's own values and the errors of transferred points are in the rig's file.
"""

import tomllib
from functools import lru_cache
from importlib import resources
from typing import Annotated

from pydantic import Field

from breastrig.core.settings_file import NotNegative, Positive, SettingsPart
from breastrig.rig.known import checked_part, known_numbers
from breastrig.rig.model import Rig

FILE = "skin_map.toml"
Count = Annotated[int, Field(ge=1)]


class SkinMapSettings(SettingsPart):
    """Settings of drawings/skin_maps/skin_map.py; lengths in m, angles in rad."""

    centres: Count
    length: Positive
    displacement: Positive
    strain: Positive
    shift_length: Positive
    landmark_error: Positive
    mark_error: Positive
    mark_length: Positive
    mark_share: Annotated[float, Field(gt=0.0, lt=1.0)]
    mark_spread: Positive
    mark_freedom: Positive
    mark_limit: Positive
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
    wall_holds: Positive
    error_share: NotNegative | None = None  # None: nobody has measured with this rig how far off carried points are
    error_skin: Positive | None = None
    error_hanging: NotNegative = 0.0  # m, the more for skin of breasts that hang in one of two stances
    wall_error: dict[str, Positive] = Field(default_factory=dict)  # m by stance: half of the chest wall's 90 % interval
    seen_wall_error: Positive
    inside_depth_share: Positive = 1.0  # of what tissue inside is off along the skin, how far along its normal


@lru_cache(maxsize=8)
def skin_map_settings(rig: Rig) -> SkinMapSettings:
    """The common settings with those of the rig."""
    file = resources.files("breastrig.drawings.skin_maps") / "default.toml"
    own = known_numbers(rig, FILE) or {}
    return checked_part(rig, FILE, SkinMapSettings, tomllib.loads(file.read_text("utf-8")) | own)
