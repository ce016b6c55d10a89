"""The middle of the breast bone, by its ends: it lies half way between notch and xiphoid by what it is.

The skin there is smooth and shows nothing of it, but often shows the two ends, and a model that slides along smooth
skin keeps neither share.  Lying skin slides a little on the bone, so the model's own place keeps a say.
"""

from breastrig.core.arrays import Array
from breastrig.relief.limits import MidSternum


def mid_sternum_step(notch: Array, xiphoid: Array, middle: Array, rules: MidSternum) -> Array:
    """(3,) m along the line between the ends, from where a model has the `middle` to where it is expected.

    notch, xiphoid, middle: (3,) m; nothing when the two ends are one place.
    """
    length = float((xiphoid - notch) @ (xiphoid - notch))
    if length == 0.0:
        return 0.0 * notch
    step: Array = rules.share * (rules.at - float((middle - notch) @ (xiphoid - notch)) / length) * (xiphoid - notch)
    return step
