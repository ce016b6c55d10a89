"""The Wise pattern (inverted T, keyhole) of a breast reduction, constructed on the patient's own skin.

All lengths are geodesic millimetres (Wise, Plast. Reconstr. Surg. 17, 1956), each side from its own landmarks:

* the new nipple is on the meridian (midclavicle to nipple) at the height of the fold, never below the nipple;
* the keyhole is an arc around it as long as the new areola's circumference, open below by `opening_deg`;
* two vertical limbs of equal length leave its ends and diverge;
* horizontal limbs join their lower ends to the ends of the fold, which may be planned above or below the patient's own.
"""

from dataclasses import dataclass

import numpy as np
from pydantic import Field
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array
from breastrig.core.errors import BadDrawing
from breastrig.core.stances import SIDES, sides_of
from breastrig.drawings.clock import FittedSkin, circle_around, on_clock
from breastrig.drawings.constructions.new_fold import fold_line
from breastrig.drawings.constructions.written_numbers import AroundAreola
from breastrig.drawings.inks import PLAN
from breastrig.geometry.geodesic import MARGIN
from breastrig.geometry.polyline import length, resampled
from breastrig.geometry.surface_points import SurfacePoints, joined
from breastrig.rig.model import DrawnShape

MARK = 0.003  # m, radius of the small circle that marks the new nipple
ARC_STEPS = 24  # of the keyhole
ARC_ROUNDS = 3  # of adjusting its radius; each leaves about a tenth of the difference
LIMBS = (50.0, 47.5, 45.0, 42.5, 40.0, 37.5, 35.0, 32.5, 30.0)  # mm, tried when no length is asked for
LEAST_LIMB = LIMBS[-1]  # mm: about the keyhole's radius (28 for an areola of 42); below it no inverted T is left
SHORT_LIMB = 40.0  # mm: shorter ones are called short; 45 to 60 is usual, 50 to 80 in large breasts
FOLD_GAP = 0.005  # m that must stay between a limb and the fold, so that the horizontal limbs have a wedge to close
FOLD_STEP = 0.001  # m between the points that are compared
WIDEST = 2.0  # of the areola's radius: as far as a keyhole's rim is from its centre, on all but the roundest breast


NIPPLE_ABOVE_FOLD = Field(
    0.0, title="New nipple above the fold", ge=-20.0, le=40.0, description="new nipple over the fold's height"
)
NIPPLE_OUTWARD = Field(
    0.0,
    title="New nipple beside the meridian",
    ge=-30.0,
    le=30.0,
    description="new nipple outwards of the meridian, along the skin",
)
NO_SHIFT = 1e-4  # m, a shift below it is none


class Reduction(AroundAreola):
    """The pattern's dimensions."""

    limb_mm: float | None = Field(
        None,
        title="Vertical limbs",
        ge=LEAST_LIMB,
        le=80.0,
        description="vertical limbs; 45 to 60 is usual; if not said 50, less over a near fold",
    )
    limb_angle_deg: float = Field(
        60.0, title="Angle between the limbs", ge=20.0, le=110.0, description="between the limbs; wider takes more skin"
    )
    opening_deg: float = Field(
        90.0, title="Opening of the keyhole", ge=30.0, le=150.0, description="of the keyhole, seen from the new nipple"
    )
    nipple_above_fold_mm: float = NIPPLE_ABOVE_FOLD
    nipple_outward_mm: float = NIPPLE_OUTWARD
    fold_below_mm: float = Field(
        0.0,
        title="New fold below the fold",
        ge=-20.0,
        le=30.0,
        description="new fold below the patient's own, along the skin",
    )

    def drawn(self, skin: FittedSkin) -> tuple[DrawnShape, ...]:
        """Four lines for each side; BadDrawing when the pattern does not fit on the breast."""
        shapes: list[DrawnShape] = []
        for side, breast in self.constructed(skin).items():
            word = SIDES[side]
            limb = 1e3 * length(breast.limbs[0])
            label = f"{word} keyhole and {'short ' if limb < SHORT_LIMB else ''}limbs of {limb:.1f} mm"
            rim = 0.5e-3 * self.areola_mm
            kept, mark = circle_around(skin, breast.nipple, rim), circle_around(skin, breast.new, MARK)
            shapes += [
                DrawnShape(f"wise_{side}", label, False, PLAN, *breast.cut(skin)),
                DrawnShape(f"wise_fold_{side}", f"{word} fold", False, PLAN, breast.fold),
                DrawnShape(f"areola_{side}", f"{word} areola to keep", True, PLAN, kept),
                DrawnShape(f"new_nipple_{side}", f"new place of the {word} nipple", True, PLAN, mark),
            ]
        return tuple(shapes)

    def constructed(self, skin: FittedSkin) -> dict[str, "WiseBreast"]:
        """The pattern on each breast, by side; BadDrawing when it does not fit."""
        return skin.constructed(self, self._constructed)

    def _constructed(self, skin: FittedSkin) -> dict[str, "WiseBreast"]:
        sides = sides_of(self.side)
        # both sides in step, so that what is measured from several places is measured at once
        rim = 0.5e-3 * self.areola_mm
        nipples = {side: skin.landmark(f"nipple_{side}") for side in sides}
        clavicles = [skin.landmark(f"midclavicle_{side}") for side in sides]
        new_folds = {side: fold_line(skin, side, 1e-3 * self.fold_below_mm) for side in sides}
        folds = {side: _on_observers_left(skin, new_folds[side]) for side in sides}
        meridians = skin.geodesics.paths(joined(clavicles), joined(list(nipples.values())))
        new = {
            side: self.new_nipple(skin, side, nipples[side], way) for side, way in zip(sides, meridians, strict=True)
        }
        skin.geodesics.look_from(joined([*nipples.values(), *new.values()]), WIDEST * rim)
        arcs = {side: self.keyhole(skin, new[side]) for side in sides}
        skin.geodesics.look_from(joined([ends(arc) for arc in arcs.values()]), MARGIN * (1e-3 * self._limbs[0]))
        lower = {side: self._limb_ends(skin, side, arcs[side], skin.at(folds[side])) for side in sides}
        outer = skin.geodesics.paths(joined([ends(folds[side]) for side in sides]), joined([*lower.values()]))
        found = {}
        for number, (side, meridian) in enumerate(zip(sides, meridians, strict=True)):
            to_arc, from_arc = skin.geodesics.paths(lower[side], ends(arcs[side]))
            first, last = outer[2 * number : 2 * number + 2]
            found[side] = WiseBreast(
                nipples[side],
                meridian,
                new[side],
                arcs[side],
                new_folds[side],
                lower[side],
                (to_arc, from_arc),
                (first, last),
            )
        return found

    @property
    def _limbs(self) -> tuple[float, ...]:
        """The limb lengths to try, mm."""
        return LIMBS if self.limb_mm is None else (self.limb_mm,)

    def keyhole(self, skin: FittedSkin, new: SurfacePoints) -> SurfacePoints:
        """The keyhole's arc, clockwise for the observer, as long as the new areola's rim, which will be sewn to it."""
        gap = np.radians(self.opening_deg) / 2.0
        angles = np.linspace(np.pi + gap, 3.0 * np.pi - gap, ARC_STEPS + 1)
        rim = 1e-3 * self.areola_mm * np.pi
        radius = rim / (2.0 * (np.pi - gap))
        arc = on_clock(skin, new, radius, angles)
        for _ in range(ARC_ROUNDS):  # circles on a breast are shorter than on flat skin
            radius *= rim / length(skin.at(arc))
            arc = on_clock(skin, new, radius, angles)
        return arc

    def _limb_ends(self, skin: FittedSkin, side: str, arc: SurfacePoints, fold: Array) -> SurfacePoints:
        """The lower ends of both limbs, which must be equally long to be sewn together."""
        starts = [arc[[k]] for k in (0, -1)]
        tree = cKDTree(resampled(fold, FOLD_STEP, False))

        def ends_clear(limb: float) -> SurfacePoints | None:
            lower = joined(
                [
                    on_clock(skin, start, 1e-3 * limb, np.array([np.pi + turn]))
                    for start, turn in zip(starts, (spread, -spread), strict=True)
                ]
            )
            limbs = [resampled(way, FOLD_STEP, False) for way in skin.geodesics.paths(joined(starts), lower)]
            return lower if np.min(tree.query(np.concatenate(limbs))[0]) > FOLD_GAP else None

        spread, lengths = np.radians(self.limb_angle_deg) / 2.0, self._limbs
        found = ends_clear(lengths[0])
        if found is not None:
            return found
        if len(lengths) > 1 and (found := ends_clear(lengths[-1])) is not None:
            too_long, clear = 0, len(lengths) - 1  # halve between the two
            while clear - too_long > 1:
                middle = (too_long + clear) // 2
                lower = ends_clear(lengths[middle])
                too_long, clear, found = (middle, clear, found) if lower is None else (too_long, middle, lower)
            return found
        if self.limb_mm is None:
            raise BadDrawing(
                f"No room for a Wise pattern on the {SIDES[side]}: limbs would be under {LEAST_LIMB:g} mm, and 45 to "
                "60 is usual. Choose the vertical pattern, a smaller areola (areola_mm) or a lower fold "
                "(fold_below_mm)."
            )
        raise BadDrawing(
            f"No room on the {SIDES[side]}: limbs of {lengths[-1]:g} mm reach the fold. Choose shorter limbs "
            "(limb_mm), a narrower angle (limb_angle_deg) or a smaller areola (areola_mm)."
        )

    def new_nipple(self, skin: FittedSkin, side: str, nipple: SurfacePoints, meridian: Array) -> SurfacePoints:
        """The new nipple: at the fold's height on the (M, 3) m meridian from collarbone to nipple, or beside that."""
        on_meridian = self.on_meridian(skin, side, nipple, meridian)
        outward = 1e-3 * self.nipple_outward_mm
        if abs(outward) < NO_SHIFT:
            return on_meridian
        to_left = (outward > 0.0) == (side == "L")  # the patient's, at three o'clock for the observer
        skin.geodesics.look_from(on_meridian, MARGIN * abs(outward))
        return on_clock(skin, on_meridian, abs(outward), np.array([0.5 * np.pi if to_left else 1.5 * np.pi]))

    def on_meridian(self, skin: FittedSkin, side: str, nipple: SurfacePoints, meridian: Array) -> SurfacePoints:
        """The meridian's point at the new nipple's height; the nipple itself where that is not lower."""
        heights: Array = meridian @ skin.axes[:, 1]
        wanted = skin.height(f"inframammary_fold_{side}") + 1e-3 * self.nipple_above_fold_mm
        if wanted <= heights[-1]:
            return nipple
        above = np.flatnonzero(heights >= wanted)
        if len(above) == 0:
            raise BadDrawing(
                f"The {SIDES[side]} nipple cannot be moved up to {self.nipple_above_fold_mm:g} mm above the fold: "
                "that is above the collarbone. Check the landmarks."
            )
        k = int(above[-1])  # the last crossing on the way down
        share = (heights[k] - wanted) / max(heights[k] - heights[k + 1], 1e-12)
        return skin.nearest(((1.0 - share) * meridian[k] + share * meridian[k + 1])[None])


@dataclass(frozen=True, eq=False)
class WiseBreast:
    """The pattern on one breast; ways are (M, 3) m, pairs begin with the observer's left."""

    nipple: SurfacePoints  # one point
    meridian: Array  # from the collarbone to the nipple
    new: SurfacePoints  # one point
    arc: SurfacePoints  # the keyhole
    fold: SurfacePoints  # as it is planned
    lower: SurfacePoints  # two points: the limbs' lower ends
    limbs: tuple[Array, Array]  # from the lower ends to the keyhole's
    outer: tuple[Array, Array]  # from the fold's ends to the limbs' lower ends

    def cut(self, skin: FittedSkin) -> tuple[SurfacePoints, tuple[int, ...]]:
        """The whole line that is cut, and its corners."""
        (to_arc, from_arc), (first, last) = self.limbs, self.outer
        parts = [first, to_arc, skin.at(self.arc), from_arc[::-1], last[::-1]]
        corners = np.cumsum([len(part) - 1 for part in parts])[:-1]
        return skin.nearest(np.concatenate([parts[0], *(part[1:] for part in parts[1:])])), tuple(corners.tolist())


def ends(line: SurfacePoints) -> SurfacePoints:
    """The line's first point and its last."""
    return line[[0, -1]]


def _on_observers_left(skin: FittedSkin, fold: SurfacePoints) -> SurfacePoints:
    """The fold, starting on the observer's left (the patient's right), as the keyhole does."""
    start, finish = skin.at(ends(fold))
    return fold[::-1] if (start - finish) @ skin.axes[:, 0] > 0.0 else fold
