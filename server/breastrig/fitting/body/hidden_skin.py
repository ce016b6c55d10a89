"""Mean distance from the fitted model to the true skin where no scan shows it, by place; data beside this file.

Estimated on virtual bodies whose whole skin is known (breastrig_studies/bodies); evidence: docs/decisions/0005.
Of supine bodies only the back's form is kept; how much deeper its hidden skin is says the height of the belly above the
table: beyond a threshold times a slope at each place, no farther than down to the table, added to that mean.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from pydantic import BaseModel, Field, FiniteFloat, model_validator

from breastrig.core.arrays import Array
from breastrig.correspondence.target import ScanTarget
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.plane import Plane
from breastrig.rig.known import known_part
from breastrig.rig.model import Rig

SCHEMA = "breastrig/hidden-skin@1"
WIDTH = 0.02  # m, of the Gaussian that blends the places' heights; they are this far apart
NOTHING = -50.0  # of a weight's logarithm: 1e-22; numbers too small for the processor take it ten times as long
ROWS = 64  # of vertices at once: what is computed of them stays in the processor's cache
BEYOND = 0.1  # of the weight of one place: where there is less, the heights die out


@dataclass(frozen=True, eq=False)
class HiddenSkin:
    """N places of a template's left side; the right side is alike, mirrored."""

    places: Array  # (N, 3) m
    normals: Array  # (N, 3) unit: an arm and the trunk beside it are not blended
    heights: Array  # (N,) m along the fitted model's normals

    def at(self, template: Array, normals: Array) -> Array:
        """(V,) m: the heights of a template's (V, 3) m vertices with (V, 3) unit normals."""
        sides = np.array([[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]])
        places, facing = ((each * sides[:, None]).reshape(-1, 3) for each in (self.places, self.normals))
        heights, result = np.tile(self.heights, 2), np.zeros(len(template))
        lengths, doubled = (places**2).sum(axis=1), -2.0 * places.T
        for first in range(0, len(template), ROWS):
            part = slice(first, first + ROWS)
            squares = (template[part] ** 2).sum(axis=1)[:, None] + lengths + template[part] @ doubled
            weights = np.exp(np.maximum(-0.5 / WIDTH**2 * squares, NOTHING)) * np.maximum(normals[part] @ facing.T, 0.0)
            result[part] = weights @ heights / np.maximum(weights.sum(axis=1), BEYOND)
        return result


class PlacesFile(BaseModel):
    """Places of a template's left side with their normals."""

    places_mm: list[tuple[FiniteFloat, FiniteFloat, FiniteFloat]]
    normals: list[tuple[FiniteFloat, FiniteFloat, FiniteFloat]]

    def check(self, numbers: list[float]) -> None:
        """ValueError when there is not one number for each place."""
        if not len(self.places_mm) == len(self.normals) == len(numbers):
            raise ValueError("it needs one normal and one number for each place")


class _File(PlacesFile):
    schema_: Literal["breastrig/hidden-skin@1"] = Field(alias="schema")
    heights_mm: list[FiniteFloat]

    @model_validator(mode="after")
    def _fits_together(self) -> "_File":
        self.check(self.heights_mm)
        return self


@lru_cache(maxsize=8)
def hidden_skin(rig: Rig, stance: str) -> Array | None:
    """(V,) m along the normals of the rig's vertices; None for a rig or stance without data."""
    stored = known_part(rig, f"hidden_{stance}.json", _File)
    if stored is None:
        return None
    kept = HiddenSkin(1e-3 * np.array(stored.places_mm), np.array(stored.normals), 1e-3 * np.array(stored.heights_mm))
    return kept.at(rig.template, vertex_normals(rig.template, rig.faces))


DEPTH_SCHEMA = "breastrig/trunk-depth@1"


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


class _DepthFile(PlacesFile):
    schema_: Literal["breastrig/trunk-depth@1"] = Field(alias="schema")
    slopes: list[FiniteFloat]
    ordinary_mm: FiniteFloat
    most_mm: FiniteFloat
    reach_mm: FiniteFloat

    @model_validator(mode="after")
    def _fits_together(self) -> "_DepthFile":
        self.check(self.slopes)
        return self


@lru_cache(maxsize=8)
def trunk_depth(rig: Rig) -> TrunkDepth | None:
    """The rig's data; None for a rig without any."""
    stored = known_part(rig, "trunk_depth.json", _DepthFile)
    if stored is None or not {"back", "belly"} <= rig.regions.keys():
        return None
    places = HiddenSkin(1e-3 * np.array(stored.places_mm), np.array(stored.normals), np.array(stored.slopes))
    slopes = places.at(rig.template, vertex_normals(rig.template, rig.faces))
    return TrunkDepth(slopes, *(1e-3 * each for each in (stored.ordinary_mm, stored.most_mm, stored.reach_mm)))


def skin_behind(rig: Rig, stance: str, target: ScanTarget, vertices: Array) -> Array | None:
    """(V,) m along the normals of the (V, 3) m fitted vertices to the expected skin where the scan shows none.

    None for a rig or stance without data.
    """
    expected = hidden_skin(rig, stance)
    deeper = trunk_depth(rig) if stance == "supine" else None
    if expected is None or deeper is None or target.table is None:
        return expected
    return expected + deeper.added(rig, target.table, vertices, expected)
