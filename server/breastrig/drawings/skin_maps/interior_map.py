"""Maps points inside the body in one stance to the same tissue in another stance of the same patient.

The skin is followed by the skin map, by the mean motion alone, as far as that reaches, beyond it by the two fitted
models; what lies inside follows by the interpolant of least bending energy in space, the thin-plate spline with the
kernel |x - y| (Duchon 1977; Bookstein 1989).  The fitted back and flanks hold it on the far side, where no chest wall
is seen.

Evidence: docs/decisions/0015.
"""

import numpy as np

from breastrig.core.arrays import Array
from breastrig.drawings.skin_maps.skin_map import FittedScan, SkinMap, within_reach
from breastrig.rig.model import Rig


def moved_inside(rig: Rig, a: FittedScan, b: FittedScan, points: Array) -> Array:
    """(M, 3) m: where (M, 3) m points inside the body of scan A are in that of scan B, each in its scan's frame.

    Raises BadDrawing when a model does not lie on its scan.
    """
    from scipy.interpolate import RBFInterpolator  # slow to load, and most fits need no spline

    first, second = (b, a) if a.stance == "supine" and b.stance != "supine" else (a, b)
    followed = within_reach(rig, first.vertices, first.vertices)
    skin = SkinMap(rig, first, second, ways=False).moved(first.vertices)
    there = np.where(followed[:, None], skin, second.vertices)
    here, there = (first.vertices, there) if first is a else (there, first.vertices)
    _, apart = np.unique(np.round(here, 5), axis=0, return_index=True)  # two equal places make it singular
    return np.asarray(RBFInterpolator(here[apart], there[apart], kernel="linear", degree=1)(points))
