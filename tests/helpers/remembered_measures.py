"""Fits that this run has measured before are not measured again: the same stance has the same measures in every report.

For tests of what a report is made into, and of where it goes.  What is remembered was measured by the report's own
function; files lie beside the remembered uploads, where processes of all tests find them.
"""

import hashlib
import os
import pickle
from pathlib import Path

import numpy as np

from breastrig.report.measures import measures
from breastrig.report.stance import Stance
from breastrig.report.table import Row
from helpers.remembered_uploads import FOLDER


def measured_once(stance: Stance) -> tuple[Row, ...]:
    """As `measures`."""
    if FOLDER not in os.environ:
        return measures(stance)
    known = Path(os.environ[FOLDER], _key(stance))
    if not known.is_file():
        rows = measures(stance)
        known.parent.mkdir(parents=True, exist_ok=True)
        making = known.with_suffix(f".{os.getpid()}")
        making.write_bytes(pickle.dumps(rows))
        making.rename(known)
    again: tuple[Row, ...] = pickle.loads(known.read_bytes())
    return again


def _key(stance: Stance) -> str:
    """Of everything that is measured."""
    total = hashlib.sha256(f"measures {stance.rig.sha256} {stance.name}".encode())
    radii = np.zeros(0) if stance.radii is None else stance.radii
    for array in (stance.vertices, stance.scan_vertices, stance.scan_faces, radii):
        total.update(np.ascontiguousarray(array).tobytes())
    for more in (stance.picked, stance.landmark_radii, stance.areolae):
        total.update(pickle.dumps(sorted(more.items())))
    return total.hexdigest()
