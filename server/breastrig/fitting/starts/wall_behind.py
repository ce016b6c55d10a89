"""A plane close behind the body is a table (scan/orient.py), or a wall behind a standing body: both look alike.

Most apps level their scans.  Where both the plane and the body are upright in the scanner's own axes it may be a wall,
and a fit has to tell (stance.py); of bodies turned at random one in sixty is upright so.  All other tables cost no fit.
"""

import numpy as np

from breastrig.fitting.task import FitTask
from breastrig.rig.similarity import umeyama
from breastrig.rig.skinning import pose
from breastrig.scan.orient import Frame

WALL = "An upright plane is close behind her, and the arms hang: a wall. If it is a table, say that she lies."
TABLE = "An upright plane is close behind her, but the arms are away: a table. If it is a wall, say that she stands."
SCANNERS_UP = np.array([0.0, 1.0, 0.0])  # as scan/orient.py has it
UPRIGHT = np.radians(15.0)  # people lean, and apps level to a few degrees


def may_be_wall(task: FitTask, frame: Frame) -> bool:
    """Whether the plane behind the body is upright in the scanner's own axes, and the body at its start as well."""
    if frame.table is None:
        return False
    points = task.rig.landmark_points()
    at_rest, placed = (
        points.positions(each, task.rig.faces) for each in (task.rig.template, pose(task.rig, task.start))
    )
    body = umeyama(at_rest, placed).rotation[:, 1]
    return bool(abs(frame.table[0] @ SCANNERS_UP) < np.sin(UPRIGHT) and body @ SCANNERS_UP > np.cos(UPRIGHT))
