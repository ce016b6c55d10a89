"""Shapes of the whole torso: MakeHuman's targets, and swellings at named places where it has none.

A `swelling` is a soft hill or hollow around a point on the skin, elongated as wished, along the smoothed normal;
a `stretch` moves skin along one axis with weights in height and depth; `bend` curves the spine.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from steps.areola import vertex_normals
from steps.breast import bump, plateau
from steps.operators import laplacian, smoothed
from steps.skeleton import smooth_step
from steps.source import Array, Source
from steps.whole_body import Template

Numbers = dict[str, Any]


def _normals(template: Template) -> Array:
    stiffness, area = laplacian(template.vertices, template.triangles)
    normal = smoothed(vertex_normals(template.vertices, template.triangles), stiffness, area, 0.015)
    return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))


def swelling(template: Template, arm: Array, n: Numbers) -> Array:
    """Hills of `size` at `at`, each with its own `radii` along x, y, z (m); mirrored, so both sides get them."""
    normal = _normals(template)
    v = template.vertices
    total = np.zeros(len(v))
    for hill in n["hills"]:
        for side in (1.0, -1.0) if hill["at"][0] else (1.0,):
            at = np.array(hill["at"]) * np.array([side, 1.0, 1.0])
            distance = np.linalg.norm((v - at) / np.array(hill["radii"]), axis=1)
            facing = np.ones(len(v))
            if "facing" in hill:
                wished = np.array(hill["facing"]) * np.array([side, 1.0, 1.0])
                facing = smooth_step((normal @ (wished / np.linalg.norm(wished)) - 0.25) / 0.5)
            total += hill["size"] * bump(distance, 1.0) * facing
    total *= 1.0 - n.get("spare_arms", 0.0) * np.clip(arm, 0.0, 1.0)
    field = total[:, None] * normal
    if "along" in n:
        along = np.array(n["along"])
        field = total[:, None] * along * np.where(np.arange(3) == 0, np.sign(v[:, :1]), 1.0)
    return np.asarray(field)


def stretch(template: Template, arm: Array, n: Numbers) -> Array:
    """Skin moves along `axis` in proportion to its distance from `origin`, inside a band of heights."""
    v = template.vertices
    axis = "xyz".index(n["axis"])
    offset = v[:, axis] - n["origin"]
    if n.get("front_only"):
        offset = np.clip(offset, 0.0, None) ** 2 / (np.abs(offset) + 0.03)
    low, high = n["band"]
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    share = plateau(v[:, 1] - middle, n.get("full", 0.3) * half, half)
    share = share * (1.0 - n.get("spare_arms", 1.0) * np.clip(arm, 0.0, 1.0))
    field = np.zeros_like(v)
    field[:, axis] = n["factor"] * offset * share
    return field


def bend(template: Template, arm: Array, n: Numbers) -> Array:
    """The upper back rounds: the spine's profile moves back by a hill in height, most at the back of the body."""
    v = template.vertices
    hill = bump(v[:, 1] - n["height"], n["reach"])
    behind = 1.0 - smooth_step((v[:, 2] - n["depth"]) / n["blend"])
    field = np.zeros_like(v)
    field[:, 2] = -n["size"] * hill * (n["whole"] + (1.0 - n["whole"]) * behind) * (1.0 - 0.7 * np.clip(arm, 0, 1))
    return field


def side_mask(template: Template, half_width: float) -> Array:
    """(V,) 1 on the left, 0 on the right, smooth across the midline; the two sides' masks sum to 1."""
    return smooth_step(template.vertices[:, 0] / half_width)


def sculpted(source: Source, template: Template, targets: list[list[Any]]) -> Array:
    """(V, 3) m: a mixture of MakeHuman's targets on the template."""
    total = sum((weight * source.target(name) for name, weight in targets), np.zeros_like(source.vertices))
    return template.carry(total)


BODY_SHAPES: dict[str, Callable[[Template, Array, Numbers], Array]] = {
    function.__name__: function for function in (swelling, stretch, bend)
}
