"""The ellipse of a mastectomy around the nipple: its axes along the skin, its long axis at the surgeon's angle.

Stewart's is transverse and rises a little towards the armpit, Orr's is steeper; skin-sparing ones are small and round.
"""

import numpy as np
from pydantic import Field

from breastrig.core.stances import OUTWARDS, SIDES, sides_of
from breastrig.drawings.clock import FittedSkin, on_clock
from breastrig.drawings.constructions.written_numbers import OnBreasts
from breastrig.drawings.inks import PLAN
from breastrig.geometry.geodesic import MARGIN
from breastrig.geometry.surface_points import joined
from breastrig.rig.model import DrawnShape

STEPS = 48  # points of the ellipse


class MastectomyEllipse(OnBreasts):
    """The ellipse's dimensions."""

    length_mm: float = Field(
        140.0, title="Length", ge=30.0, le=260.0, description="of the long axis along the skin, through the nipple"
    )
    width_mm: float = Field(
        70.0, title="Width", ge=20.0, le=160.0, description="across it; as much as can be closed again"
    )
    axis_deg: float = Field(
        20.0,
        title="Axis",
        ge=-90.0,
        le=90.0,
        description="of the long axis over the horizontal, rising towards the armpit; 0 lies across, 90 stands",
    )

    def drawn(self, skin: FittedSkin) -> tuple[DrawnShape, ...]:
        """`mastectomy_L`, `mastectomy_R`; BadDrawing when the skin ends before."""
        sides = sides_of(self.side)
        nipples = {side: skin.landmark(f"nipple_{side}") for side in sides}
        reach = 0.5e-3 * max(self.length_mm, self.width_mm)
        skin.geodesics.look_from(joined(list(nipples.values())), MARGIN * reach)
        shapes = []
        for side in sides:
            # clockwise from 12 for the observer, on whose right is the patient's left
            axis = OUTWARDS[side] * (np.pi / 2.0 - np.radians(self.axis_deg))
            angles = 2.0 * np.pi * np.arange(STEPS) / STEPS
            along, across = np.cos(angles) / self.length_mm, np.sin(angles) / self.width_mm
            radii = 0.5e-3 / np.hypot(along, across)
            rim = on_clock(skin, nipples[side], radii, axis + angles)
            shapes.append(DrawnShape(f"mastectomy_{side}", f"ellipse of the {SIDES[side]} side", True, PLAN, rim))
        return tuple(shapes)
