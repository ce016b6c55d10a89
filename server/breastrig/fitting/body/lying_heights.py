"""How high the parts of lying bodies are above the table, all together, kept as data beside this file.

Of virtual women the whole back lies up to three centimetres higher in one than in another: some rest on their shoulder
blades, some are raised by their own build or by how they were laid down.  What a scan shows from above tells most of
it: arms that lie higher, and how thick the trunk is.  So mean and covariance are kept of all parts, seen and unseen
(evaluation/lying_heights.py writes the file): no person's body is in them.
"""

import json
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from importlib import resources

import numpy as np

from breastrig.core.arrays import Array, Booleans, Integers
from breastrig.geometry.spread_out import spread_out
from breastrig.rig.model import Rig

SCHEMA = "breastrig/lying-heights@1"
MOST = 12  # vertices that stand for a part which the scan shows: all of them cost time
BACK = "back of "  # what a part of the back is called by


@dataclass(frozen=True, eq=False)
class LyingHeights:
    """G parts: of each bone, or bone and its other side, what belongs to the region "back", and what does not."""

    parts: tuple[Integers, ...]  # vertices of each
    of_back: Booleans  # (G,)
    mean: Array  # (G,) m above the table
    covariance: Array  # (G, G) m²

    def back_given(self, heights: Array, alone: float) -> tuple[Array, Array]:
        """((B,) m, (B, B) m²): mean and covariance of the back's parts where the others have these of (V,) heights,
        when every part lies `alone` (m) off by itself as well."""
        covariance = self.covariance + alone**2 * np.eye(len(self.mean))
        back, others = np.flatnonzero(self.of_back), np.flatnonzero(~self.of_back)
        slope = np.linalg.solve(covariance[np.ix_(others, others)], covariance[np.ix_(others, back)]).T
        beside = means_of([self.parts[k] for k in others], heights) - self.mean[others]
        told = slope @ covariance[np.ix_(others, back)]
        return self.mean[back] + slope @ beside, covariance[np.ix_(back, back)] - told

    @cached_property
    def back(self) -> tuple[Integers, ...]:
        """Vertices of its B parts."""
        return tuple(part for part, of_back in zip(self.parts, self.of_back, strict=True) if of_back)


def parts_of(rig: Rig) -> dict[str, Integers]:
    """Vertices by part, the back's first; all of the back, and some that stand for what a scan shows."""
    leading = np.argmax(rig.weights_by_bone, axis=0)
    back: Integers = rig.regions.get("back", np.zeros(0, dtype=np.int64))
    of_back, others = {}, {}
    for bone in rig.bones:
        if bone.mirror >= bone.name:
            led = np.flatnonzero(np.isin(leading, [rig.bone_names.index(name) for name in (bone.name, bone.mirror)]))
            of_back[BACK + bone.name] = np.intersect1d(led, back)
            others[bone.name] = _some(rig, np.setdiff1d(led, back))
    return {name: vertices for name, vertices in (*of_back.items(), *others.items()) if len(vertices)}


def _some(rig: Rig, vertices: Integers) -> Integers:
    """Those of (N,) vertices that stand for them, alike on both sides."""
    left = vertices[rig.template[vertices, 0] >= 0.0]
    if not len(left):
        return vertices
    chosen = left[spread_out(rig.template[left], MOST // 2)]
    both: Integers = np.union1d(chosen, rig.mirror_vertices[chosen])
    return both


def means_of(parts: Iterable[Integers], heights: Array) -> Array:
    """(G,) means over the parts of (V,) heights."""
    return np.array([heights[part].mean() for part in parts])


@lru_cache(maxsize=8)
def lying_heights(rig: Rig) -> LyingHeights | None:
    """None for a rig of which nothing is known."""
    file = resources.files("breastrig.fitting") / "body" / f"{rig.name}_lying_heights.json"
    if not file.is_file():
        return None
    stored, parts = json.loads(file.read_text("utf-8")), parts_of(rig)
    if stored["schema"] != SCHEMA or stored["parts"] != [*parts]:
        return None
    factors = 1e-3 * np.array(stored["factors_mm"])  # (K, G); the covariance is FᵀF
    of_back = np.array([name.startswith(BACK) for name in parts])
    return LyingHeights(tuple(parts.values()), of_back, 1e-3 * np.array(stored["mean_mm"]), factors.T @ factors)
