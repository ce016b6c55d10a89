"""Shapes of the left breast that MakeHuman lacks, made from anatomy on the breast's own coordinates.

Each function takes the template and its breast and gives (V, 3) m for weight 1; the right side is the mirror
image.  The areola rides along rigidly, so that no shape grows a spike out of the nipple.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from steps.breast import Breast, bump, plateau
from steps.operators import volume_gradient
from steps.source import Array
from steps.whole_body import Template

Numbers = dict[str, Any]


def _areola_rides(field: Array, b: Breast, full: float = 0.010, reach: float = 0.024) -> Array:
    """The field with its mean around the nipple in place of what it does on the nipple."""
    share = plateau(b.from_tip, full, reach)[:, None]
    near = (b.from_tip > full) & (b.from_tip < reach)
    return np.asarray((1 - share) * field + share * field[near].mean(axis=0))


def quadrant(template: Template, b: Breast, n: Numbers) -> Array:
    """One quadrant fuller: a soft swelling at (lateral, upward) of the footprint."""
    distance = np.hypot(b.lateral - n["lateral"], b.upward - n["upward"])
    direction = b.skin_normal + 0.6 * b.normal
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    field = n["size"] * (bump(distance, n["reach"]) * b.mask)[:, None] * direction
    return _areola_rides(field, b)


def projection(template: Template, b: Breast, n: Numbers) -> Array:
    """The whole breast stands further forward, most where it is highest."""
    share = np.clip(b.height / b.height.max(), 0.0, 1.0) ** n.get("power", 1.0) * b.mask
    return _areola_rides(n["size"] * share[:, None] * b.axis, b)


def apex_round(template: Template, b: Breast, n: Numbers) -> Array:
    """From a cone to a dome: fuller around the areola, the areola itself a little back."""
    ring = np.exp(-(((b.from_tip - n["ring"]) / n["width"]) ** 2)) * b.mask
    field = n["size"] * ring[:, None] * b.skin_normal
    back = -n["back"] * bump(b.from_tip, n["ring"] * 1.1)[:, None] * b.axis
    return _areola_rides(field + back, b)


def shift(template: Template, b: Breast, n: Numbers) -> Array:
    """The breast slides over the chest wall, sideways or upwards."""
    share = plateau(b.radius, n["full"], n["reach"]) * b.torso
    along = n.get("lateral", 0.0) * b.along_lateral + n.get("up", 0.0) * b.along_up
    return _areola_rides(np.asarray(share[:, None] * along), b)


def base_width(template: Template, b: Breast, n: Numbers) -> Array:
    """A wider footprint: both borders move apart, the inside follows in proportion."""
    share = b.lateral * plateau(b.radius, 0.6, 1.5) * b.torso
    swell = bump(b.radius - 0.75, 0.7) * np.clip(np.abs(b.lateral), 0.0, 1.0) * b.mask
    field = n["size"] * share[:, None] * b.along_lateral + 0.5 * n["size"] * swell[:, None] * b.normal
    return _areola_rides(field, b)


def supine_spread(template: Template, b: Breast, n: Numbers) -> Array:
    """Lying down: the base widens, the mound slides outwards and upwards, and flattens until its volume is kept."""
    relative = np.clip(b.height / b.height.max(), 0.0, 1.0) * b.mask
    base = plateau(b.radius, n["full"], n["reach"]) * b.torso
    widen = base[:, None] * (
        n["widen_lateral"] * b.lateral[:, None] * b.along_lateral + n["widen_up"] * b.upward[:, None] * b.along_up
    )
    slide = (0.35 * base + 0.65 * relative)[:, None] * (n["lateral"] * b.along_lateral + n["up"] * b.along_up)
    spread = _areola_rides(widen + slide, b)
    flat = _areola_rides(b.mask[:, None] * (b.wall - template.vertices), b)
    gradient = volume_gradient(template.vertices, template.triangles)
    share = -float((gradient * spread).sum()) / float((gradient * flat).sum())
    return np.asarray(spread + share * flat)


def shrink(template: Template, b: Breast, n: Numbers) -> Array:
    """The breast sinks back towards the chest wall, the nipple keeps its form."""
    field = -n["share"] * b.mask[:, None] * (template.vertices - b.wall)
    return _areola_rides(field, b, full=0.003, reach=0.013)


def nipple_shift(template: Template, b: Breast, n: Numbers) -> Array:
    """Areola and nipple slide over the breast: a turn about the breast's middle."""
    centre = b.tip - n["depth"] * b.axis
    turn = np.array([0.0, 1.0, 0.0]) if "lateral" in n else -np.cross(np.array([0.0, 1.0, 0.0]), b.axis)
    turn /= np.linalg.norm(turn)
    angle = n.get("lateral", n.get("up", 0.0)) / n["depth"]
    field = angle * np.cross(turn, template.vertices - centre)
    share = plateau(b.from_tip, n["full"], n["reach"]) * b.torso
    return np.asarray(share[:, None] * field)


def nipple_size(template: Template, b: Breast, n: Numbers) -> Array:
    """A longer and wider nipple."""
    offset = template.vertices - b.tip
    across = offset - (offset @ b.axis)[:, None] * b.axis
    out = np.linalg.norm(across, axis=1)
    length = n["length"] * plateau(out, 0.002, n["base"]) * (b.from_tip < 0.03)
    wide = n["width"] * out * plateau(out, 0.003, 2.2 * n["base"]) / n["base"]
    wide = np.where(b.from_tip < 0.03, wide, 0.0)
    direction = across / np.maximum(out, 1e-9)[:, None]
    return np.asarray(length[:, None] * b.axis + wide[:, None] * direction)


def areola_size(template: Template, b: Breast, n: Numbers) -> Array:
    """A larger areola, a little raised; the skin around makes room."""
    offset = template.vertices - b.tip
    along = (offset * b.skin_normal).sum(axis=1, keepdims=True) * b.skin_normal
    across = offset - along
    out = np.linalg.norm(across, axis=1)
    share = np.where(out < n["edge"], out / n["edge"], plateau(out, n["edge"], n["reach"]))
    share = np.where(b.from_tip < 1.3 * n["reach"], share, 0.0)
    direction = across / np.maximum(out, 1e-9)[:, None]
    raised = n["raise"] * plateau(b.from_tip, 0.3 * n["edge"], 1.6 * n["edge"])
    return np.asarray(n["size"] * share[:, None] * direction + raised[:, None] * b.skin_normal)


BREAST_SHAPES: dict[str, Callable[[Template, Breast, Numbers], Array]] = {
    function.__name__: function
    for function in (
        quadrant, projection, apex_round, shift, base_width, supine_spread, shrink, nipple_shift,
        nipple_size, areola_size,
    )
}  # fmt: skip
