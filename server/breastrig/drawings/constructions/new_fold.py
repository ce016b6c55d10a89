"""The fold under a breast, and a new one that is planned above or below it.

Each place of the fold goes straight down the skin (or up) by the same length of tape, so the new fold has the shape of
the patient's own; between the places that are measured the others follow.
"""

import numpy as np

from breastrig.core.errors import BadDrawing
from breastrig.drawings.clock import FittedSkin, on_clock
from breastrig.geometry.geodesic import MARGIN
from breastrig.geometry.polyline import arc_lengths, interpolated
from breastrig.geometry.surface_points import SurfacePoints

MEASURED = 7  # places along the fold that are measured; each costs some milliseconds
LEAST = 1e-4  # m, a shift below it is none


def fold_line(skin: FittedSkin, side: str, below: float = 0.0) -> SurfacePoints:
    """The model's line inframammary_fold_L or _R, moved down the skin by `below` m (up where that is negative).

    BadDrawing when the model has no such line, or the skin ends before.
    """
    fold = _own_fold(skin, side)
    if abs(below) < LEAST:
        return fold
    at = skin.at(fold)
    along = arc_lengths(at)
    chosen = np.unique(np.searchsorted(along, np.linspace(0.0, along[-1], MEASURED)).clip(0, len(at) - 1))
    measured = fold[chosen]
    skin.geodesics.look_from(measured, MARGIN * abs(below))
    angle = np.array([np.pi if below > 0.0 else 0.0])
    moved = np.concatenate([skin.at(on_clock(skin, measured[[k]], abs(below), angle)) for k in range(len(chosen))])
    moves = moved - at[chosen]
    shift = interpolated(along, along[chosen], moves)
    return skin.nearest(at + shift)


def middle_of_fold(skin: FittedSkin, side: str) -> tuple[int, SurfacePoints]:
    """The place of the patient's own fold at half of its length, and its number, also in a new fold."""
    fold = _own_fold(skin, side)
    at = skin.at(fold)
    along = arc_lengths(at)
    number = int(np.searchsorted(along, 0.5 * along[-1]))
    return number, fold[[number]]


def _own_fold(skin: FittedSkin, side: str) -> SurfacePoints:
    name = f"inframammary_fold_{side}"
    for drawing in skin.rig.drawings:
        for shape in drawing.shapes:
            if shape.name == name and not shape.closed:
                return shape.points
    raise BadDrawing(f"This drawing ends at the line {name}, which no drawing of this model has.")
