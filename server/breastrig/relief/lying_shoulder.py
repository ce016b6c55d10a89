"""The tips of supine shoulders, from three lengths from the notch: to the form's tip and to the arm's front.

A supine body has no edge of a hanging arm below the tip, but an arm that is brought forwards carries the end of the
shoulder inwards.  Heights along the body are left as the fit has them, which is right to 5 mm.
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
