"""The soft part of one breast, of the rig's tetrahedra, in any body: between skin and chest wall, held around.

What moves is the breast and the tissue AROUND it.  The chest wall holds; a softer layer on it is the loose fascia, in
which the breast slides.
"""

import tomllib
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib import resources
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.rig.model import Rig
from breastrig.volume.breast_skin import AROUND, OF_AN_ARM, breast_skins
from breastrig.volume.known_volume import known_volume
from breastrig.volume.tetrahedra import depths
from breastrig.volume.volume_mesh import REGIONS, SOFT, outer_triangles
from breastrig_studies.gravity.statics import SoftBody, Tissue

GLAND = 0.035  # m, how far gland reaches behind the nipple
LAYER = 0.65  # depth from which on tissue is the wall's loose layer
TAUT = 1.1  # stretch of living skin without loads; slack skin buckles
DIRECTIONS = {"standing": (0.0, -1.0, 0.0), "supine": (0.0, 0.0, -1.0), "prone": (0.0, 0.0, 1.0)}
G = 9.81  # m/s²


@dataclass(frozen=True)
class Stiffness:
    """The stiffness of one body's tissues."""

    fat: float  # Pa, shear modulus
    gland: float  # times fat's
    fascia: float  # times fat's: the layer on the chest wall
    skin: float  # N/m: shear modulus times thickness

    def times(self, factor: float) -> "Stiffness":
        """The stiffness with fat, gland, fascia and skin stiffer by this factor."""
        return replace(self, fat=factor * self.fat, skin=factor * self.skin)


@dataclass(frozen=True, eq=False)
class SoftBreast:
    """N nodes and T tetrahedra of a side."""

    nodes: Integers  # (N,) of the rig's volume
    tetrahedra: Integers  # (T, 4) of these
    skin: Integers  # (S, 3) triangles of these
    held: Booleans  # (N,)
    gland: Array  # (T,) share of gland: most behind the nipple, none at the breast's edge
    loose: Booleans  # (T,) in the layer on the wall

    def body(self, points: Array, stiffness: Stiffness) -> SoftBody:
        """The soft body, at rest without loads at (N, 3) m."""
        shear = stiffness.fat * (1.0 + (stiffness.gland - 1.0) * self.gland)
        shear[self.loose] = stiffness.fat * stiffness.fascia
        return SoftBody(points, self.tetrahedra, self.skin, self.held, Tissue(shear, stiffness.skin, stretch=TAUT))

    def on(self, vertices: Integers, values: Array) -> Array:
        """(P, 3) of (N, 3) values at the rig's (P,) vertices; zero where the breast does not reach."""
        place = np.minimum(np.searchsorted(self.nodes, vertices), len(self.nodes) - 1)
        return np.asarray(np.where((self.nodes[place] == vertices)[:, None], values[place], 0.0))


@lru_cache(maxsize=8)
def soft_breast(rig: Rig, side: str) -> SoftBreast:
    """The soft tissue of side "L" or "R". Raises BadInput for a rig whose inside is not known."""
    known, region = known_volume(rig), REGIONS.index(f"breast_{side}")
    count, sign = len(rig.template), 1.0 if side == "L" else -1.0
    away = cKDTree(rig.template[rig.regions[f"breast_{side}"]]).query(known.points)[0]
    around = (away < AROUND) & (sign * known.points[:, 0] > -1e-6)
    other_skin = np.setdiff1d(np.arange(count), breast_skins(rig)[side == "R"].skin)
    arm = rig.skin_weights[:, rig.bone_names.index(f"upper_arm_{side}")] >= OF_AN_ARM
    around[count : 2 * count] &= ~arm
    soft = (known.regions == region) | ((known.regions < SOFT) & around[known.tetrahedra].all(axis=1))
    soft &= ~np.isin(known.tetrahedra, other_skin).any(axis=1)
    nodes, tetrahedra = np.unique(known.tetrahedra[soft], return_inverse=True)
    tetrahedra = tetrahedra.reshape(-1, 4)
    outer = outer_triangles(tetrahedra)
    skin = {tuple(row) for row in np.sort(rig.faces, axis=1).tolist()}
    is_skin = np.array([tuple(row) in skin for row in np.sort(nodes[outer], axis=1).tolist()])
    middle = known.points[nodes][tetrahedra].mean(axis=1)
    nipple = rig.template[rig.regions[f"areola_{side}"]].mean(axis=0)
    return SoftBreast(
        nodes=nodes,
        tetrahedra=tetrahedra,
        skin=outer[is_skin],
        held=np.isin(np.arange(len(nodes)), outer[~is_skin]),
        gland=np.exp(-0.5 * (np.linalg.norm(middle - nipple, axis=1) / GLAND) ** 2),
        loose=depths(rig)[nodes][tetrahedra].mean(axis=1) > LAYER,
    )


def published() -> dict[str, Any]:
    """The distributions of tissue.toml with their sources."""
    return tomllib.loads((resources.files("breastrig_studies.gravity") / "tissue.toml").read_text("utf-8"))


def drawn(table: dict[str, Any], deviations: Array) -> Stiffness:
    """The stiffness at (4,) standard normal deviations of fat, gland, fascia, skin from the medians."""
    names = ("fat", "gland", "fascia", "skin")
    return Stiffness(
        **{
            name: float(table[name]["median"] * np.exp(table[name]["log_sd"] * away))
            for name, away in zip(names, deviations, strict=True)
        }
    )
