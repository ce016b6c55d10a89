"""Mean and covariance of bone scales and shape weights over bodies, kept as data beside this file.

They are of virtual bodies whose whole skin is known, fitted with all of it
(breastrig_studies/body_statistics.py): no person's body, and no scan, is in them.  Rigs without such a file keep the
two plain priors.
"""

import json
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources

import numpy as np

from breastrig.core.arrays import Array
from breastrig.rig.model import Rig

SCHEMA = "breastrig/body-statistics@1"


@dataclass(frozen=True, eq=False)
class BodyStatistics:
    """N = 3 B + S: the scales of all bones, bone by bone, then the shape weights."""

    mean_scales: Array  # (3 B,)
    covariance: Array  # (N, N)
    bodies: int  # how many it was made from


@lru_cache(maxsize=8)
def body_statistics(rig: Rig) -> BodyStatistics | None:
    """For this rig; None where there are none for its bones and shapes.  A rig may lack some of the shapes."""
    file = resources.files("breastrig.fitting") / "body" / f"{rig.name}.json"
    if not file.is_file():
        return None
    stored = json.loads(file.read_text("utf-8"))
    places = {name: place for place, name in enumerate(stored["shapes"])}
    if stored["schema"] != SCHEMA or stored["bones"] != [*rig.bone_names] or not places.keys() >= {*rig.shape_names}:
        return None
    scales = 3 * len(rig.bones)
    kept = np.concatenate([np.arange(scales), [scales + places[name] for name in rig.shape_names]]).astype(np.int64)
    factors = np.array(stored["factors"])[:, kept]  # (K, N); the covariance is FᵀF
    return BodyStatistics(np.array(stored["mean_scales"]), factors.T @ factors, stored["bodies"])
