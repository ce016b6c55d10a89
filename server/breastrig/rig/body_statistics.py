"""Mean and covariance of bone scales and shape weights over bodies, kept as data beside the rig.

They are of virtual bodies whose whole skin is known, fitted with all of it
(breastrig_studies/bodies): no person's body, and no scan, is in them.  Rigs without such a file keep the
two plain priors.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from pydantic import BaseModel, Field, FiniteFloat, model_validator

from breastrig.core.arrays import Array
from breastrig.rig.known import known_part
from breastrig.rig.model import Rig

SCHEMA = "breastrig/body-statistics@1"


@dataclass(frozen=True, eq=False)
class BodyStatistics:
    """N = 3 B + S: the scales of all bones, bone by bone, then the shape weights."""

    mean_scales: Array  # (3 B,)
    covariance: Array  # (N, N)
    bodies: int  # how many it was made from


class _File(BaseModel):
    schema_: Literal["breastrig/body-statistics@1"] = Field(alias="schema")
    bodies: int
    bones: list[str]
    shapes: list[str]
    mean_scales: list[FiniteFloat]
    factors: list[list[FiniteFloat]]

    @model_validator(mode="after")
    def _fits_together(self) -> "_File":
        scales = 3 * len(self.bones)
        if len(self.mean_scales) != scales or any(len(row) != scales + len(self.shapes) for row in self.factors):
            raise ValueError("mean_scales has three numbers for each bone, each row of factors one for each shape more")
        return self


@lru_cache(maxsize=8)
def body_statistics(rig: Rig) -> BodyStatistics | None:
    """This rig's statistics; None where there are none for its bones and shapes. A rig may lack some of the shapes."""
    stored = known_part(rig, "bodies.json", _File)
    places = {} if stored is None else {name: place for place, name in enumerate(stored.shapes)}
    if stored is None or stored.bones != [*rig.bone_names] or not places.keys() >= {*rig.shape_names}:
        return None
    scales = 3 * len(rig.bones)
    kept = np.concatenate([np.arange(scales), [scales + places[name] for name in rig.shape_names]]).astype(np.int64)
    factors = np.array(stored.factors)[:, kept]  # (K, N); the covariance is FᵀF
    return BodyStatistics(np.array(stored.mean_scales), factors.T @ factors, stored.bodies)
