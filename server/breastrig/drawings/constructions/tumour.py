"""The tumour's projection on the skin: a circle, its radius along the skin, around a place that the surgeon names."""

from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field

from breastrig.core.errors import BadDrawing
from breastrig.core.stances import SIDES
from breastrig.core.units import BEYOND, distance_text
from breastrig.drawings.clock import FittedSkin, angle_of, circle_around, on_clock
from breastrig.drawings.constructions.written_numbers import WrittenNumbers
from breastrig.drawings.inks import LESION
from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rig.model import DrawnShape

OFF_BREAST = 0.03  # m beyond the base of the breast; its axillary tail reaches so far
OFF_SKIN = 0.03  # m from a given point to the fitted skin; more is another frame or unit
RADIUS: float = Field(
    title="Radius", ge=1.0, le=80.0, description="of the circle along the skin; margin included, T3 starts at 25"
)


def _on_the_dial(hour: float) -> float:
    if not 0.0 < hour < 13.0:
        raise ValueError("an hour of the clock lies above 0 and below 13 (12.5 is half past twelve)")
    return hour


class Tumour(WrittenNumbers):
    """A tumour's place by the clock, and its size."""

    side: Literal["L", "R"] = Field(title="Side", description="the patient's side")
    clock: Annotated[float, AfterValidator(_on_the_dial)] = Field(
        title="Hour",
        description="hour as read by an observer facing the patient: 3 is to the patient's left on both breasts",
        json_schema_extra={"minimum": 0.5, "maximum": 12.5},  # what forms offer: once round the dial in half hours
    )
    distance_mm: float = Field(
        title="From the nipple", ge=0.0, le=200.0, description="from the nipple along the skin; a breast is not longer"
    )
    radius_mm: float = RADIUS

    def drawn(self, skin: FittedSkin) -> tuple[DrawnShape, ...]:
        """The circle `tumour_L` or `tumour_R`; BadDrawing when it is not on that breast."""
        return (circle(skin, self.centre(skin), 1e-3 * self.radius_mm, self.side),)

    def centre(self, skin: FittedSkin) -> SurfacePoints:
        """The tumour's centre; BadDrawing when it is not on that breast."""
        nipple = skin.landmark(f"nipple_{self.side}")
        centre = nipple
        if self.distance_mm > 0.0:
            centre = on_clock(skin, nipple, 1e-3 * self.distance_mm, np.array([angle_of(self.clock)]))
        breast = skin.rig.regions.get(f"breast_{self.side}")
        if breast is not None:
            gap = float(np.linalg.norm(skin.vertices[breast] - skin.at(centre), axis=1).min())
            if gap > OFF_BREAST:
                raise BadDrawing(
                    f"A tumour at {self.clock:g} o'clock, {self.distance_mm:g} mm from the nipple, would lie "
                    f"{1e3 * gap:.0f} mm beside the {SIDES[self.side]} breast; check side, hour and distance."
                )
        return centre


class PickedTumour(WrittenNumbers):
    """A tumour around a place that was picked on the scan."""

    x_mm: float = Field(
        title="x", allow_inf_nan=False, description="of the centre in the scan's frame, whatever its unit"
    )
    y_mm: float = Field(title="y", allow_inf_nan=False, description="likewise")
    z_mm: float = Field(title="z", allow_inf_nan=False, description="likewise")
    radius_mm: float = RADIUS

    def drawn(self, skin: FittedSkin) -> tuple[DrawnShape, ...]:
        """The circle around the skin's point next to the place; BadDrawing when that is off the skin."""
        named = np.clip([self.x_mm, self.y_mm, self.z_mm], -BEYOND, BEYOND)  # farther is as far off the skin
        place = 1e-3 * named
        centre = skin.nearest(place[None])
        at = skin.at(centre)[0]
        gap = float(np.linalg.norm(at - place))
        if gap > OFF_SKIN:
            raise BadDrawing(f"The tumour's centre is {distance_text(gap)} off the skin; check its frame and unit.")
        left = float((at - skin.vertices.mean(axis=0)) @ skin.axes[:, 0]) > 0.0
        return (circle(skin, centre, 1e-3 * self.radius_mm, "L" if left else "R"),)


def circle(skin: FittedSkin, centre: SurfacePoints, radius: float, side: str) -> DrawnShape:
    """The points at `radius` (m) along the skin."""
    rim = circle_around(skin, centre, radius)
    return DrawnShape(f"tumour_{side}", f"tumour of the {SIDES[side]} breast", True, LESION, rim)
