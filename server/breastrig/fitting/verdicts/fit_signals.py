"""Numbers by which a right fit of a torso differs from any other, taken before the free-form refinement.

The mean distance is under 2 mm even on a plate.  Others differ: single far places, opposite normals, little coverage,
scales at their limits, and without landmarks a second position that is nearly as good.  Around hanging breasts, narrow
folds, normals are not compared.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial import cKDTree

from breastrig.core.arrays import Booleans, Integers
from breastrig.core.stances import SIDES
from breastrig.correspondence.distances import Comparison
from breastrig.rig.body_statistics import body_statistics
from breastrig.rig.model import Rig
from breastrig.rig.parameters import RigParameters

SCAN_POINTS = 4000  # of the scan; more change the shares by less than 1 %
BEYOND = 0.005  # m; scanner and model's limits together explain less than this on nearly all skin
HANGING, HANGS = "ptosis", 1.0  # the shape by which a breast hangs, and its weight from which on it does
BONES = 0.3  # share of what a bone moves that is near the breasts, for it to count there
EXPLAINED = 0.008  # m; a scan point this near to the model, facing as it does, is explained by it


@dataclass(frozen=True)
class FitSignals:
    """Numbers of one fit; nan where there is nothing to measure."""

    clearness: float  # how much worse the best start in another position was, as a share; nan: not looked for
    seen: float  # share of the model's vertices that have scan
    distance_p95: float  # m, of 100 model vertices with scan 95 are nearer to it
    beyond: float  # share of the model's vertices with scan that are farther than BEYOND from it
    angle_p90: float  # rad, between the normals of model and scan, likewise
    explained: float  # share of the scan points that face as the model does within EXPLAINED
    facing: float  # share of the scan within the model's openings that faces as the model does
    stretch: float  # root mean square of the logarithms of the bones' scales, over those of the mean of bodies
    limits: float  # share of the shapes that ended at a limit


def fit_signals(
    rig: Rig, x: RigParameters, compared: Comparison, clearness: float | None, part: Booleans | None = None
) -> FitSignals:
    """The signals of the model posed by `x`, `compared` with its scan; of (V,) `part` of its vertices."""
    is_whole = part is None
    part = np.ones(len(compared.vertices), dtype=np.bool_) if part is None else part
    found = compared.accepted
    here = part[found.vertices]
    stiff = part.copy()
    for side, weight in _hanging(rig, x).items():
        if weight > HANGS:
            stiff[rig.regions.get(f"breast_{side}", [])] = False
    asked = stiff[found.vertices]
    cosines = np.einsum("mi,mi->m", compared.normals[found.vertices[asked]], found.normals[asked])
    stride = max(1, len(compared.target.vertices) // SCAN_POINTS)
    distances, inside, facing = compared.from_scan(stride)
    if not is_whole:
        nearest = cKDTree(compared.vertices).query(compared.target.vertices[::stride])[1]
        inside = inside & part[nearest]
    gaps = distances[inside & facing]
    low, high = (np.array([getattr(shape, end) for shape in rig.shapes]) for end in ("min", "max"))
    known = body_statistics(rig)
    mean = 1.0 if known is None else known.mean_scales.reshape(x.scales.shape)
    bones = rig.skin_weights[part].sum(axis=0) > BONES * rig.skin_weights.sum(axis=0)
    at_limit = ((x.weights <= low + 1e-6) | (x.weights >= high - 1e-6))[part[_most_moved(rig)]]
    some, any_asked = bool(here.any()), bool(asked.any())
    return FitSignals(
        clearness=np.nan if clearness is None else clearness,
        seen=np.count_nonzero(here) / np.count_nonzero(part),
        distance_p95=float(np.percentile(found.distances[here], 95)) if some else np.nan,
        beyond=float((found.distances[here] > BEYOND).mean()) if some else np.nan,
        angle_p90=float(np.arccos(np.clip(np.percentile(cosines, 10), -1.0, 1.0))) if any_asked else np.nan,
        explained=float((gaps <= EXPLAINED).mean()) if len(gaps) else np.nan,
        facing=float(facing[inside].mean()) if inside.any() else np.nan,
        stretch=float(np.sqrt(np.mean(np.log(x.scales / mean)[bones] ** 2))),
        limits=float(at_limit.mean()) if len(at_limit) else 0.0,
    )


@lru_cache(maxsize=4)
def _most_moved(rig: Rig) -> Integers:
    """(S,) the vertex that each shape moves the farthest."""
    return np.asarray(np.linalg.norm(rig.blendshapes, axis=2).argmax(axis=1))


def _hanging(rig: Rig, x: RigParameters) -> dict[str, float]:
    """Weight of the shape by side; of a rig without it nothing."""
    names = {side: f"{HANGING}_{side}" for side in SIDES}
    return {side: float(x.weights[rig.shape_names.index(n)]) for side, n in names.items() if n in rig.shape_names}
