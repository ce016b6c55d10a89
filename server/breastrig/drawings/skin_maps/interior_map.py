"""Maps points inside the body in one stance to the same tissue in another stance of the same patient.

The skin is followed by the skin map, by the mean motion alone, as far as that reaches, beyond it by the two fitted
models; what lies inside follows by the interpolant of least bending energy in space, the thin-plate spline with the
kernel |x - y| (Duchon 1977; Bookstein 1989).  The fitted back and flanks hold it on the far side, where no chest wall
is seen.  Where the scan that points come from shows the wall (an MRI), what lies on it goes with the breastbone.

Evidence: docs/decisions/0015, 0033.
"""

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.drawings.skin_maps.settings import skin_map_settings
from breastrig.drawings.skin_maps.skin_map import FittedScan, SkinMap, within_reach
from breastrig.geometry.boundary import boundary_edges
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.normals import face_crosses
from breastrig.rig.model import Rig
from breastrig.rig.similarity import umeyama

BREASTBONE = ("suprasternal_notch", "xiphoid")  # landmarks at its ends
SAME = 1e-9  # m between two nearest places that are one
BESIDE = 0.03  # m from the line between them, on the rig's template: skin that moves with the bone


def moved_inside(rig: Rig, a: FittedScan, b: FittedScan, points: Array) -> Array:
    """(M, 3) m: where (M, 3) m points inside the body of scan A are in that of scan B, each in its scan's frame.

    Raises BadDrawing when a model does not lie on its scan.
    """
    from scipy.interpolate import RBFInterpolator  # slow to load, and most fits need no spline

    first, second = (b, a) if a.stance == "supine" and b.stance != "supine" else (a, b)
    followed = within_reach(rig, first.vertices, first.vertices)
    skin = SkinMap(rig, first, second, ways=False, marks=False).moved(first.vertices)
    there = np.where(followed[:, None], skin, second.vertices)
    here, there = (first.vertices, there) if first is a else (there, first.vertices)
    _, apart = np.unique(np.round(here, 5), axis=0, return_index=True)  # two equal places make it singular
    moved = np.asarray(RBFInterpolator(here[apart], there[apart], kernel="linear", degree=1)(points))
    if a.wall is None or not rig.has_landmarks(BREASTBONE):
        return moved
    return held(rig, moved, with_breastbone(rig, here, there, points), over(a.wall, points))


def held(rig: Rig, moved: Array, fast: Array, heights: Array) -> Array:
    """(M, 3) m between (M, 3) `moved` freely and `fast` with the breastbone, by (M,) m heights over the chest wall."""
    share = np.exp(-heights / skin_map_settings(rig).wall_holds)
    return np.asarray(moved + share[:, None] * (fast - moved))


def with_breastbone(rig: Rig, here: Array, there: Array, points: Array) -> Array:
    """(M, 3) m: points moved rigidly with the skin over the breastbone, from (V, 3) m `here` to `there`."""
    top, low = rig.landmark_points(BREASTBONE).positions(rig.template, rig.faces)
    share = np.clip((rig.template - top) @ (low - top) / ((low - top) @ (low - top)), 0.0, 1.0)
    over_bone = np.linalg.norm(rig.template - top - share[:, None] * (low - top), axis=1) < BESIDE
    turn = umeyama(here[over_bone], there[over_bone]).rotation
    return np.asarray((points - here[over_bone].mean(axis=0)) @ turn.T + there[over_bone].mean(axis=0))


def over(wall: ClosestPointSearch, points: Array) -> Array:
    """(M,) m: how far points lie in front of a wall, or from its end where they lie beside it; 0 behind it."""
    nearest = wall.query(points)
    normals = face_crosses(wall.vertices, wall.triangles[nearest.faces])
    in_front = np.einsum("mi,mi->m", points - nearest.points, normals) > 0.0
    return np.where(in_front | lie_beside(wall, points), nearest.distances, 0.0)


def lie_beside(wall: ClosestPointSearch, points: Array) -> Booleans:
    """(M,) whether what is nearest to points of a wall is its border: it may go on there, unseen."""
    border = ClosestPointSearch(wall.vertices, boundary_edges(wall.triangles)[:, [0, 1, 1]])
    return np.asarray(border.distances(points)[1] < wall.distances(points)[1] + SAME)
