"""The handles of a tumour: its centre, which is an hour and a distance from the nipple, and its radius."""

import numpy as np

from breastrig.drawings.clock import FittedSkin, clock_place, on_clock
from breastrig.drawings.constructions.tumour import Tumour
from breastrig.drawings.handles.areola import OUTSIDE
from breastrig.drawings.handles.handle import Handle, towards
from breastrig.geometry.surface_points import SurfacePoints


def tumour_handles(pattern: Tumour, skin: FittedSkin) -> list[Handle]:
    """BadDrawing when the tumour is not on that breast."""
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
