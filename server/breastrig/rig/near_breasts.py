"""The part of a rig's skin near the breasts, where plans are made: breastbone, folds, the armpits' front."""

from functools import lru_cache

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Booleans
from breastrig.core.stances import SIDES
from breastrig.rig.model import Rig

NEAR = 0.08  # m from the breasts, on the model at rest
CARRIES = 0.05  # of the breasts' skin, mean weight of a bone of the trunk; arms only come near
OUTSIDE = 0.01  # m over the fitted skin; what is to lie inside and lies farther out is in another frame or unit


@lru_cache(maxsize=8)
def near_breasts(rig: Rig) -> Booleans:
    """(V,) the model's vertices where plans are made; all of a rig without breasts."""
    regions = [rig.regions[name] for name in (f"breast_{side}" for side in SIDES) if name in rig.regions]
    if not regions:
        return np.ones(len(rig.template), dtype=np.bool_)
    breasts = np.concatenate(regions)
    away, _ = cKDTree(rig.template[breasts]).query(rig.template, distance_upper_bound=NEAR)
    trunk = rig.skin_weights[breasts].mean(axis=0) > CARRIES
    return np.asarray(np.isfinite(away) & (rig.skin_weights[:, trunk].sum(axis=1) > 0.5))
