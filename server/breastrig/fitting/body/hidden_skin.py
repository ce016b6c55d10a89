"""Mean distance from the fitted model to the true skin where no scan shows it, by place; data beside this file.

Estimated on virtual bodies whose whole skin is known (breastrig_studies/bodies); evidence: docs/decisions/0005.
Of supine bodies only the back's form is kept; trunk_depth.py adds its height.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from pydantic import BaseModel, Field, FiniteFloat, model_validator

from breastrig.core.arrays import Array
from breastrig.geometry.normals import vertex_normals
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
    """(V,) m along the normals of the rig's vertices; None for a rig or stance of which nothing is known."""
    stored = known_part(rig, f"hidden_{stance}.json", _File)
    if stored is None:
        return None
    kept = HiddenSkin(1e-3 * np.array(stored.places_mm), np.array(stored.normals), 1e-3 * np.array(stored.heights_mm))
    return kept.at(rig.template, vertex_normals(rig.template, rig.faces))
