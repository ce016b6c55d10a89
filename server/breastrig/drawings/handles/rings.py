"""The handles of what is drawn around a place: periareolar rings, mastectomy ellipse, tumour."""

import numpy as np

from breastrig.core.stances import OUTWARDS, sides_of
from breastrig.drawings.clock import FittedSkin, clock_place, on_clock
from breastrig.drawings.constructions.ellipse import MastectomyEllipse
from breastrig.drawings.constructions.periareolar import Periareolar
from breastrig.drawings.constructions.tumour import Tumour
from breastrig.drawings.handles.handle import OUTSIDE, Handle, across_handle, areola_handle, towards
from breastrig.geometry.surface_points import SurfacePoints

ASIDE = np.radians(30.0)  # from the lateral end of the long axis, upwards: where the ellipse is held to be turned


def periareolar_handles(pattern: Periareolar, skin: FittedSkin) -> list[Handle]:
    """The handles of periareolar rings: areola, outer ring (laterally and below), lift (above)."""
    found = []
    for side in sides_of(pattern.side):
        nipple = skin.landmark(f"nipple_{side}")
        ring = ("outer_mm", side, nipple, pattern.outer_mm)
        found += [
            areola_handle(skin, side, nipple, pattern.areola_mm),
            across_handle(skin, "outer", *ring, OUTSIDE[side]),
            across_handle(skin, "outer_below", *ring, np.pi),
            _lift(pattern, skin, side, nipple),
        ]
    return found


def _lift(pattern: Periareolar, skin: FittedSkin, side: str, nipple: SurfacePoints) -> Handle:
    top = 0.5 * pattern.outer_mm + pattern.lift_mm
    at = skin.at(on_clock(skin, nipple, 1e-3 * top, np.array([0.0])))[0]

    def values_at(place: SurfacePoints) -> dict[str, float]:
        return {"lift_mm": 1e3 * skin.geodesics.distance(nipple, place) - 0.5 * pattern.outer_mm}

    return Handle(f"lift_{side}", side, {"lift_mm": pattern.lift_mm}, at, towards(skin.at(nipple)[0], at), values_at)


def ellipse_handles(pattern: MastectomyEllipse, skin: FittedSkin) -> list[Handle]:
    """The handles of a mastectomy ellipse: both ends of both axes, and one to turn it; its centre is the nipple."""
    found = []
    for side in sides_of(pattern.side):
        nipple, out = skin.landmark(f"nipple_{side}"), OUTWARDS[side]
        axis = out * (np.pi / 2.0 - np.radians(pattern.axis_deg))
        long, wide = (
            ("length_mm", side, nipple, pattern.length_mm),
            ("width_mm", side, nipple, pattern.width_mm),
        )
        found += [
            across_handle(skin, "length_lateral", *long, axis),
            across_handle(skin, "length_medial", *long, axis + np.pi),
            across_handle(skin, "width_upper", *wide, axis - out * np.pi / 2.0),
            across_handle(skin, "width_lower", *wide, axis + out * np.pi / 2.0),
            _axis(pattern, skin, side, nipple, axis),
        ]
    return found


def _axis(pattern: MastectomyEllipse, skin: FittedSkin, side: str, nipple: SurfacePoints, axis: float) -> Handle:
    out = OUTWARDS[side]
    radius = 0.5e-3 / np.hypot(np.cos(ASIDE) / pattern.length_mm, np.sin(ASIDE) / pattern.width_mm)
    at, higher = skin.at(on_clock(skin, nipple, float(radius), axis - out * np.array([ASIDE, ASIDE + 0.05])))

    def values_at(place: SurfacePoints) -> dict[str, float]:
        _, angle = clock_place(skin, nipple, place)
        over = 90.0 - float(np.degrees(out * angle + ASIDE))
        return {"axis_deg": (over + 90.0) % 180.0 - 90.0}

    return Handle(f"axis_{side}", side, {"axis_deg": pattern.axis_deg}, at, towards(at, higher), values_at)


def tumour_handles(pattern: Tumour, skin: FittedSkin) -> list[Handle]:
    """The handles of a tumour; BadDrawing when it is not on that breast."""
    side = pattern.side
    nipple, centre = skin.landmark(f"nipple_{side}"), pattern.centre(skin)

    def place_of(place: SurfacePoints) -> dict[str, float]:
        distance, angle = clock_place(skin, nipple, place)
        hour = float(np.degrees(angle)) / 30.0 % 12.0
        return {"clock": hour if hour >= 0.5 else hour + 12.0, "distance_mm": 1e3 * distance}

    at = skin.at(centre)[0]
    rim = skin.at(on_clock(skin, centre, 1e-3 * pattern.radius_mm, np.array([OUTSIDE[side]])))[0]
    return [
        Handle(
            f"centre_{side}",
            side,
            {"clock": pattern.clock, "distance_mm": pattern.distance_mm},
            at,
            np.zeros(3),
            place_of,
        ),
        Handle(
            f"radius_{side}",
            side,
            {"radius_mm": pattern.radius_mm},
            rim,
            towards(at, rim),
            lambda place: {"radius_mm": 1e3 * skin.geodesics.distance(centre, place)},
        ),
    ]
