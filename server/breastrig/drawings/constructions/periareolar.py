"""The periareolar pattern of a small lift or reduction (Benelli, Aesthet. Plast. Surg. 14, 1990): two rings.

The inner one is the areola that is kept.  The outer one is an ellipse whose upper rim lies as high above the nipple as
the nipple shall rise, and which takes the skin between the two; both are measured along the skin.
"""

from typing import Self

import numpy as np
from pydantic import Field, model_validator

from breastrig.core.stances import SIDES, sides_of
from breastrig.drawings.clock import FittedSkin, circle_around, on_clock
from breastrig.drawings.constructions.written_numbers import AroundAreola
from breastrig.drawings.inks import PLAN
from breastrig.geometry.geodesic import MARGIN
from breastrig.geometry.surface_points import joined
from breastrig.rig.model import DrawnShape

STEPS = 36  # points of the outer ring


class Periareolar(AroundAreola):
    """The rings' dimensions."""

    outer_mm: float = Field(
        80.0, title="Outer ring", ge=35.0, le=140.0, description="width of the outer ring; over 100 scars widen"
    )
    lift_mm: float = Field(
        15.0, title="Lift", ge=0.0, le=50.0, description="of the nipple: the outer ring reaches so much higher"
    )

    @model_validator(mode="after")
    def _rings_do_not_meet(self) -> Self:
        if self.outer_mm <= self.areola_mm:
            raise ValueError("the outer ring must be wider than the new areola")
        return self

    def drawn(self, skin: FittedSkin) -> tuple[DrawnShape, ...]:
        """Two rings for each side; BadDrawing when the skin ends before."""
        sides = sides_of(self.side)
        nipples = {side: skin.landmark(f"nipple_{side}") for side in sides}
        half = 0.5e-3 * self.outer_mm
        skin.geodesics.look_from(joined(list(nipples.values())), MARGIN * (half + 1e-3 * self.lift_mm))
        angles = 2.0 * np.pi * np.arange(STEPS) / STEPS  # clockwise from 12
        radii = half + 1e-3 * self.lift_mm * np.clip(np.cos(angles), 0.0, 1.0)
        shapes = []
        for side in sides:
            word = SIDES[side]
            ring = on_clock(skin, nipples[side], radii, angles)
            kept = circle_around(skin, nipples[side], 0.5e-3 * self.areola_mm)
            shapes += [
                DrawnShape(f"periareolar_{side}", f"{word} outer ring", True, PLAN, ring),
                DrawnShape(f"areola_{side}", f"{word} areola to keep", True, PLAN, kept),
            ]
        return tuple(shapes)
