"""The left breast as a patch with coordinates: where on its base a point lies and how far it stands off the chest.

The wall behind the breast is the thin-plate continuation of the skin around it.  On the wall each point has polar
coordinates in an egg-shaped footprint: 0 at the centre, 1 on the breast's border, angle 0 lateral, 90 degrees up.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from steps.areola import vertex_normals
from steps.operators import laplacian, smoothed, thin_plate
from steps.source import Array
from steps.whole_body import Template


@dataclass(frozen=True, eq=False)
class Breast:
    """Fields over all V vertices that describe the left breast."""

    wall: Array  # (V, 3) m, the chest wall under each point, the point itself outside of the footprint
    height: Array  # (V,) m, over the wall
    lateral: Array  # (V,) position in the footprint, 1 = lateral border
    upward: Array  # (V,) the same upwards
    radius: Array  # (V,) length of the two
    mask: Array  # (V,) 1 in the middle, smoothly 0 outside of the footprint
    torso: Array  # (V,) 1 on this side's chest wall, smoothly 0 across the midline, towards the back and on the arm
    normal: Array  # (V, 3) of the wall
    along_lateral: Array  # (V, 3) unit, on the wall, around the chest towards the side
    along_up: Array  # (V, 3) unit, on the wall, towards the head
    skin_normal: Array  # (V, 3) of the breast itself, smoothed
    tip: Array  # (3,) m, the nipple's tip
    axis: Array  # (3,) its direction
    from_tip: Array  # (V,) m, straight distance to the nipple


def bump(x: Array, reach: float) -> Array:
    """1 at 0, 0 from `reach` on, twice differentiable (Wendland)."""
    t = np.clip(np.abs(x) / reach, 0.0, 1.0)
    return np.asarray((1.0 - t) ** 4 * (4.0 * t + 1.0))


def plateau(x: Array, full: float, reach: float) -> Array:
    """1 up to `full`, then smoothly down to 0 at `reach`."""
    t = np.clip((np.abs(x) - full) / (reach - full), 0.0, 1.0)
    return np.asarray(1.0 - t**3 * (t * (6.0 * t - 15.0) + 10.0))


def _coordinates(points: Array, r: dict[str, Any]) -> tuple[Array, Array]:
    around = np.arctan2(points[:, 0], points[:, 2] - r["chest_axis_z"])
    lateral = (around - r["centre_angle"]) / r["half_angle"]
    dy = points[:, 1] - r["centre_height"]
    upward = np.where(dy > 0, dy / r["half_up"], dy / r["half_down"])
    return lateral, upward


def breast_fields(template: Template, arm: Array, recipe: dict[str, Any]) -> Breast:
    """The left breast; `arm` (V,) is the share of the arm in each vertex, which must not follow the breast."""
    r = recipe["breast"]
    v, t = template.vertices, template.triangles
    stiffness, area = laplacian(v, t)
    lateral, upward = _coordinates(v, r)
    front = (v[:, 2] > r["back_limit"]) & (v[:, 0] > -r["midline_reach"])
    inside = front & (np.hypot(lateral, upward) < 1.0) & (arm < 0.5)
    wall = thin_plate(v, inside, stiffness, area)
    for _ in range(2):
        lateral, upward = _coordinates(wall, r)
    radius = np.where(front, np.hypot(lateral, upward), 9.0)
    normal = vertex_normals(wall, t)
    normal = smoothed(normal, stiffness, area, 0.008)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    around = np.cross(np.array([0.0, 1.0, 0.0]), normal)
    around /= np.linalg.norm(around, axis=1, keepdims=True)
    skin = smoothed(vertex_normals(v, t), stiffness, area, 0.010)
    skin /= np.linalg.norm(skin, axis=1, keepdims=True)
    tip = v[template.rings[-1][0]]
    torso = (1.0 - np.clip(arm, 0.0, 1.0)) ** 2
    torso *= plateau(np.maximum(r["midline_full"] - v[:, 0], 0.0), 0.0, r["midline_full"] + r["midline_reach"])
    torso *= plateau(np.maximum(r["back_full"] - v[:, 2], 0.0), 0.0, r["back_full"] - r["back_limit"])
    return Breast(
        wall=wall,
        height=((v - wall) * normal).sum(axis=1),
        lateral=lateral,
        upward=upward,
        radius=radius,
        mask=plateau(radius, r["mask_full"], r["mask_reach"]) * torso,
        torso=torso,
        normal=normal,
        along_lateral=around,
        along_up=np.cross(normal, around),
        skin_normal=skin,
        tip=tip,
        axis=template.axis,
        from_tip=np.linalg.norm(v - tip, axis=1),
    )
