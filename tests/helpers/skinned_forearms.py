"""The forearm by dual quaternions and with a corrective, its wrist far bent in the scan: for browser tests.

python skinned_forearms.py FOLDER writes FOLDER/WAY/forearm.glb, scan.ply and landmarks.json (mm).
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from breastrig.rig.model import Corrective
from breastrig.rig.skinning import pose
from breastrig_studies.output.rig_files import write_rig
from helpers.forearm import bent, forearm_rig, write_scan

BENT, WEIGHTS = 0.9, np.array([0.4, 0.2, -0.3, 0.1])  # rad, of the shapes


def write_skinned_forearms(folder: Path) -> None:
    linear = forearm_rig()
    swollen = linear.template * [0.3, 0.0, 0.3] * linear.skin_weights[:, :1]
    for way in ("dual_quaternion", "corrective"):
        made = (Corrective("swollen", 0, (2, 0, 0), swollen),) if way == "corrective" else ()
        rig = replace(linear, skinning=way, correctives=made)
        write_rig(rig, folder / way)
        skin = pose(rig, bent(rig, BENT, WEIGHTS))
        write_scan(folder / way, rig, skin, skin)


if __name__ == "__main__":
    write_skinned_forearms(Path(sys.argv[1]))
