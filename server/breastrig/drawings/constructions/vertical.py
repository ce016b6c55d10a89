"""The vertical pattern of a reduction (Lejour, Plast. Reconstr. Surg. 94, 1994): keyhole and two limbs that meet.

The new nipple and its keyhole are those of the Wise pattern.  From the keyhole's ends two limbs run down, `width_mm`
apart at half their way, and meet above the fold on the breast's meridian: no scar lies in the fold.
"""

from dataclasses import dataclass

import numpy as np
from pydantic import Field

from breastrig.core.arrays import Array
from breastrig.core.errors import BadDrawing
from breastrig.core.stances import SIDES, sides_of
from breastrig.drawings.clock import FittedSkin, circle_around
from breastrig.drawings.constructions.reduction import (
    MARK,
    NIPPLE_ABOVE_FOLD,
    NIPPLE_OUTWARD,
    WIDEST,
    Reduction,
    ends,
)
from breastrig.drawings.constructions.written_numbers import AroundAreola
from breastrig.drawings.inks import PLAN
from breastrig.geometry.polyline import length, point_along, resampled
from breastrig.geometry.surface_points import SurfacePoints, joined
from breastrig.rig.model import DrawnShape

LEAST = 0.01  # m that the limbs are long at least


class Vertical(AroundAreola):
    """The pattern's dimensions."""

    width_mm: float = Field(
        60.0, title="Width", ge=20.0, le=120.0, description="between the limbs at half their way; the pinched skin"
    )
    above_fold_mm: float = Field(
        25.0, title="End above the fold", ge=10.0, le=60.0, description="where the limbs meet; 20 to 40 is usual"
    )
    nipple_above_fold_mm: float = NIPPLE_ABOVE_FOLD
    nipple_outward_mm: float = NIPPLE_OUTWARD

    def drawn(self, skin: FittedSkin) -> tuple[DrawnShape, ...]:
        """Three lines for each side; BadDrawing when the pattern does not fit on the breast."""
        rim = 0.5e-3 * self.areola_mm
        shapes: list[DrawnShape] = []
        for side, breast in self.constructed(skin).items():
            cut, corners = self._cut(skin, breast)
            kept, mark = circle_around(skin, breast.nipple, rim), circle_around(skin, breast.new, MARK)
            word = SIDES[side]
            shapes += [
                DrawnShape(f"vertical_{side}", f"{word} keyhole and limbs", True, PLAN, cut, corners),
                DrawnShape(f"areola_{side}", f"{word} areola to keep", True, PLAN, kept),
                DrawnShape(f"new_nipple_{side}", f"new place of the {word} nipple", True, PLAN, mark),
            ]
        return tuple(shapes)

    def constructed(self, skin: FittedSkin) -> dict[str, "VerticalBreast"]:
        """The pattern on each breast, by side; BadDrawing when it does not fit."""
        return skin.constructed(self, self._constructed)

    def _constructed(self, skin: FittedSkin) -> dict[str, "VerticalBreast"]:
        sides = sides_of(self.side)
        wise = self._wise
        found = {}
        for side in sides:
            nipple = skin.landmark(f"nipple_{side}")
            (meridian,) = skin.geodesics.paths(skin.landmark(f"midclavicle_{side}"), nipple)
            new = wise.new_nipple(skin, side, nipple, meridian)
            skin.geodesics.look_from(joined([nipple, new]), WIDEST * 0.5e-3 * self.areola_mm)
            arc = wise.keyhole(skin, new)
            way, lowest = self._lowest(skin, side, nipple)
            found[side] = VerticalBreast(nipple, meridian, new, arc, way, lowest)
        return found

    @property
    def _wise(self) -> Reduction:
        """The Wise pattern with the same new nipple and keyhole."""
        shared = self.model_dump(include={"areola_mm", "nipple_above_fold_mm", "nipple_outward_mm"})
        return Reduction.model_validate(shared)

    def on_meridian(self, skin: FittedSkin, side: str, nipple: SurfacePoints, meridian: Array) -> SurfacePoints:
        """The meridian's point at the new nipple's height, as in the Wise pattern."""
        return self._wise.on_meridian(skin, side, nipple, meridian)

    def _lowest(self, skin: FittedSkin, side: str, nipple: SurfacePoints) -> tuple[Array, SurfacePoints]:
        """The (M, 3) m way from the fold to the nipple, and where the limbs meet on it."""
        (way,) = skin.geodesics.paths(skin.landmark(f"inframammary_fold_{side}"), nipple)
        along = 1e-3 * self.above_fold_mm
        if length(way) < along + LEAST:
            raise BadDrawing(
                f"No room for a vertical pattern on the {SIDES[side]}: the fold is only {1e3 * length(way):.0f} mm "
                "below the nipple. Let the limbs meet nearer to the fold (above_fold_mm), or take the periareolar "
                "pattern."
            )
        return way, skin.nearest(point_along(way, along)[None])

    def _cut(self, skin: FittedSkin, breast: "VerticalBreast") -> tuple[SurfacePoints, tuple[int, ...]]:
        """The closed outline: keyhole, one limb down, the other one up; and its corners."""
        half = 0.5e-3 * self.width_mm
        first, last = (skin.at(ends(breast.arc))[[k]] for k in (0, 1))
        middle, across = breast.middle(skin), breast.across(skin)
        # the observer sees the arc's first end on his left: limb by limb through a point beside the middle
        limbs = []
        for end, out in ((first, across), (last, -across)):
            beside = skin.nearest((middle + half * out)[None])
            upper, lower = skin.geodesics.paths(joined([skin.nearest(end), beside]), joined([beside, breast.lowest]))
            limbs.append(_rounded(np.concatenate([upper, lower[1:]])))
        down, up = limbs[1], limbs[0][::-1]
        arc = skin.at(breast.arc)
        outline = np.concatenate([arc, down[1:], up[1:-1]])
        corners = (0, len(arc) - 1, len(arc) - 2 + len(down))
        return skin.nearest(outline), corners


@dataclass(frozen=True, eq=False)
class VerticalBreast:
    """The pattern on one breast, but for the limbs."""

    nipple: SurfacePoints  # one point
    meridian: Array  # (M, 3) m from the collarbone to the nipple
    new: SurfacePoints  # one point
    arc: SurfacePoints  # the keyhole; the observer sees its first end on his left
    way: Array  # (M, 3) m from the fold to the nipple
    lowest: SurfacePoints  # one point: where the limbs meet

    def middle(self, skin: FittedSkin) -> Array:
        """(3,) m between the limbs, at half their way."""
        first, last = skin.at(ends(self.arc))
        return np.asarray(0.5 * (0.5 * (first + last) + skin.at(self.lowest)[0]))

    def across(self, skin: FittedSkin) -> Array:
        """(3,) unit, from the last end of the arc to the first."""
        first, last = skin.at(ends(self.arc))
        return np.asarray((first - last) / np.linalg.norm(first - last))


def _rounded(way: Array) -> Array:
    """The (M, 3) m way through three points without the bend in its middle: a parabola."""
    even = resampled(way, 0.002, False)
    share = np.linspace(0.0, 1.0, len(even))[:, None]
    middle = point_along(way, 0.5 * length(way))
    control = 2.0 * middle - 0.5 * (way[0] + way[-1])
    return np.asarray((1 - share) ** 2 * way[0] + 2 * share * (1 - share) * control + share**2 * way[-1])
