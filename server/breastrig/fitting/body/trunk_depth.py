"""How much deeper than the fitted model the hidden skin of a lying body is, by how high her belly lies above the table.

The table is seen and so is the belly, but not what lies between them: the model answers with the depth that trunks have
in common, and the deeper a trunk is, the higher above the table that leaves its back, up to 30 mm.  Belly above a
certain height times a slope of each place is added to what is expected of hidden skin (hidden_skin.py), no farther than
down to the table.  Of trunks that are not so deep nothing is said: our ways of computing how bodies lie down disagree
about which of them lie higher and which lower.  The landmarks and all that is seen stay where the fit has them.

The data, beside this file, are of virtual bodies (breastrig_studies/trunk_depth.py): no person's body is in them.
Mean / 95 % in mm over hidden skin of lying bodies, women alike, without it and with what the other women tell:

                            choosing half              reporting half             dev bodies
    no landmark given   5.9 / 14.3  5.4 / 12.7      7.5 / 17.7  5.9 / 14.6      7.9 / 17.5  5.7 / 13.9
    those seen given    5.6 / 13.6  5.3 / 12.7      8.0 / 19.0  6.3 / 15.8      9.1 / 20.3  6.5 / 14.8

Tried: the heights of all parts, seen and unseen, with their covariance.  As a term of the fit the back comes as near
(5.5, 7.8, 6.4), but given landmarks of one woman get 0.5 mm worse and bodies lying by finite elements 1.4 mm farther
off; over the fit, each woman by the others, 5 mm farther for bodies lying by our formula.
What is left is how high each back lies: of 36 bodies of the choosing half, no landmark given, before the layer over the
model, 6.1 / 14.1; with each back's own mean height taken away 4.6 / 11.4.  Nothing that is seen tells it: of 2,324 sets
of one to three (heights, widths and slopes of the flanks; heights of belly, breastbone, folds, shoulders and arms; the
trunk's tilt), each woman by the others, the best has it to 3.4 mm for 3.9, and takes dev bodies from 3.3 to 4.9.  Backs
of our cohort lie 26 to 39 mm above the table on the mean, the given patients' 42 to 59, with fronts as high.
"""

import json
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources

import numpy as np

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.body.hidden_skin import HiddenSkin, hidden_skin
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.plane import Plane
from breastrig.rig.model import Rig

SCHEMA = "breastrig/trunk-depth@1"


@dataclass(frozen=True, eq=False)
class TrunkDepth:
    slopes: Array  # (V,) m along the normals, for a metre of the belly's height beyond `ordinary`
    ordinary: float  # m, mean height of the belly above the table up to which nothing is added
    most: float  # m beyond it that count
    reach: float  # m, mean height of the fitted back above what is its table; a plane farther off is none

    def added(self, rig: Rig, table: Plane, vertices: Array, expected: Array) -> Array:
        """(V,) m along the normals of (V, 3) m fitted vertices, beyond the (V,) m that are expected of all bodies."""
        above = vertices @ table.normal - table.height
        if above[rig.regions["back"]].mean() > self.reach:
            return np.zeros(len(vertices))
        excess = np.clip(above[rig.regions["belly"]].mean() - self.ordinary, 0.0, self.most)
        down = -vertex_normals(vertices, rig.faces) @ table.normal
        room = np.maximum(above - expected * down, 0.0) / np.maximum(down, 1e-9)  # to the table
        return np.asarray(np.minimum(self.slopes * excess, np.where(down > 0.0, room, np.inf)))


@lru_cache(maxsize=8)
def trunk_depth(rig: Rig) -> TrunkDepth | None:
    """None for a rig of which nothing is known."""
    file = resources.files("breastrig.fitting") / "body" / f"{rig.name}_trunk_depth.json"
    if not file.is_file() or not {"back", "belly"} <= rig.regions.keys():
        return None
    stored = json.loads(file.read_text("utf-8"))
    if stored["schema"] != SCHEMA:
        return None
    places = HiddenSkin(1e-3 * np.array(stored["places_mm"]), np.array(stored["normals"]), np.array(stored["slopes"]))
    slopes = places.at(rig.template, vertex_normals(rig.template, rig.faces))
    lengths = (1e-3 * float(stored[name]) for name in ("ordinary_mm", "most_mm", "reach_mm"))
    return TrunkDepth(slopes, *lengths)


def skin_behind(rig: Rig, stance: str, target: ScanTarget, vertices: Array) -> Array | None:
    """(V,) m along the normals of the (V, 3) m fitted vertices, where skin that the scan does not show is expected.

    None for a rig or stance of which nothing is known.
    """
    expected = hidden_skin(rig, stance)
    deeper = trunk_depth(rig) if stance == "supine" else None
    if expected is None or deeper is None or target.table is None:
        return expected
    return expected + deeper.added(rig, target.table, vertices, expected)
