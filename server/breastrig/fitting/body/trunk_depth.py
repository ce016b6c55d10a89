"""How much deeper than the fitted model a supine body's hidden skin is, by the height of her belly above the table.

Height of the belly above a threshold times a slope at each place, no farther than down to the table, added to the mean
of hidden_skin.py.  Estimated on virtual bodies (breastrig_studies/bodies); evidence: docs/decisions/0005.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from pydantic import Field, FiniteFloat, model_validator

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.body.hidden_skin import HiddenSkin, PlacesFile, hidden_skin
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.plane import Plane
from breastrig.rig.known import known_part
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


class _File(PlacesFile):
    schema_: Literal["breastrig/trunk-depth@1"] = Field(alias="schema")
    slopes: list[FiniteFloat]
    ordinary_mm: FiniteFloat
    most_mm: FiniteFloat
    reach_mm: FiniteFloat

    @model_validator(mode="after")
    def _fits_together(self) -> "_File":
        self.check(self.slopes)
        return self


@lru_cache(maxsize=8)
def trunk_depth(rig: Rig) -> TrunkDepth | None:
    """None for a rig of which nothing is known."""
    stored = known_part(rig, "trunk_depth.json", _File)
    if stored is None or not {"back", "belly"} <= rig.regions.keys():
        return None
    places = HiddenSkin(1e-3 * np.array(stored.places_mm), np.array(stored.normals), np.array(stored.slopes))
    slopes = places.at(rig.template, vertex_normals(rig.template, rig.faces))
    return TrunkDepth(slopes, *(1e-3 * each for each in (stored.ordinary_mm, stored.most_mm, stored.reach_mm)))


def skin_behind(rig: Rig, stance: str, target: ScanTarget, vertices: Array) -> Array | None:
    """(V,) m along the normals of the (V, 3) m fitted vertices, where skin that the scan does not show is expected.

    None for a rig or stance of which nothing is known.
    """
    expected = hidden_skin(rig, stance)
    deeper = trunk_depth(rig) if stance == "supine" else None
    if expected is None or deeper is None or target.table is None:
        return expected
    return expected + deeper.added(rig, target.table, vertices, expected)
