"""Named sets of vertices: what belongs to which part of the body."""

from typing import Any

import numpy as np

from steps.areola import vertex_normals
from steps.breast import Breast
from steps.source import Array, Booleans, Integers
from steps.whole_body import Template


def regions(
    template: Template, b: Breast, weights: Array, names: list[str], recipe: dict[str, Any]
) -> dict[str, Integers]:
    """Sorted vertex indices of each region; left and right are mirror images."""
    r = recipe["regions"]
    v = template.vertices
    normal = vertex_normals(v, template.triangles)
    arm = {side: weights[:, names.index(f"upper_arm_{side}")] > r["arm_share"] for side in "LR"}
    any_arm = arm["L"] | arm["R"]
    breast = (b.radius <= r["breast_radius"]) & ~any_arm
    areola = np.isin(np.arange(len(v)), np.concatenate(template.rings))
    neck = v[:, 1] + r["neck_tilt"] * v[:, 2] > r["neck_height"]
    neck &= np.abs(v[:, 0]) < r["neck_half_width"]
    both_breasts = breast | breast[template.mirror]
    belly = (normal[:, 2] > 0.25) & (v[:, 1] < r["belly_top"]) & ~both_breasts
    back = (normal[:, 2] < -0.2) & ~any_arm & ~neck
    chest = (normal[:, 2] > 0.0) & (v[:, 1] >= r["belly_top"]) & ~both_breasts & ~any_arm & ~neck
    sets: dict[str, Booleans] = {
        "breast_L": breast, "breast_R": breast[template.mirror], "areola_L": areola,
        "areola_R": areola[template.mirror], "belly": belly, "back": back, "chest": chest,
        "arm_L": arm["L"], "arm_R": arm["R"], "neck": neck,
    }  # fmt: skip
    return {name: np.flatnonzero(inside) for name, inside in sets.items()}
