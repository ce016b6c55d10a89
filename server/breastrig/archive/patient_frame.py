"""From a scan's frame to the patient's: what archives and viewers of images expect."""

import numpy as np

from breastrig.core.arrays import Array
from breastrig.files.result import ResultFile
from breastrig.report.body_frame import body_frame
from breastrig.report.stance import Stance
from breastrig.scan.volumes.label_map import FRAME


def to_patient(stance: Stance, result: ResultFile) -> Array:
    """(4, 4) from the scan's frame, m, to the patient's left, back and head (LPS), m.

    The scan of an image's label map is in that frame already, and stays there.  Else the axes are those of the fitted
    trunk, and the origin is in its middle.
    """
    found = np.eye(4)
    if FRAME in result.notes and not result.predicted:
        return found
    frame = body_frame(stance.rig, stance.vertices)
    found[:3, :3] = frame.axes[:, [0, 2, 1]].T * [[1.0], [-1.0], [1.0]]
    found[:3, 3] = -found[:3, :3] @ frame.middle
    return found


def moved(matrix: Array, points: Array) -> Array:
    """(N, 3) points by a (4, 4) matrix."""
    return np.asarray(points @ matrix[:3, :3].T + matrix[:3, 3])
