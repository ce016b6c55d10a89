"""The tips of lying shoulders, by how high the arm lies that is away from the body.

Who lies has no edge of a hanging arm below the tip.  But whoever brings the arm from hanging to the side and forwards
carries the shoulder's end inwards, and the higher the arm's front lies over the notch of the breast bone, the farther;
fits without picks see the arm's height well, and let the shoulder slide outwards and in front instead.  A line through
the three lengths from the notch that both show says how far the tip is off.  It says nothing of the height along the
body, in which fits are right to 5 mm.
"""

import numpy as np

from breastrig.core.arrays import Array
from breastrig.relief.limits import LyingShoulder


def lying_tip(notch: Array, tip: Array, arm: Array, rules: LyingShoulder) -> Array | None:
    """(3,) m, where the tip is expected of whose form has it at `tip`; (3,) m each, with the notch and the most
    frontal place of the upper `arm`.

    The axes are outwards on this side, up and front.  None where the lengths are none of a lying body.
    """
    lengths = np.array([1.0, tip[0] - notch[0], tip[2] - notch[2], arm[2] - notch[2]])
    step = np.array([lengths @ rules.outwards, 0.0, lengths @ rules.front])
    return tip + step if np.linalg.norm(step) <= rules.farthest else None
