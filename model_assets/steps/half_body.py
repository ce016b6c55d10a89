"""From the source's quads to one clean half of the template (x >= 0, the patient's left).

Subdivide the torso, cut it with planes (mid-plane, waist, neck, arm) and around the areola, remesh what is left
with edges as long as the recipe wishes, and close the areola with rings.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from steps.areola import axis_frame, distance_from_axis, filled, nipple_axis
from steps.remesh import Sizing, remesh
from steps.source import Array, Booleans, Integers, Source
from steps.subdivide import subdivide
from steps.surface import Surface, clipped, compacted, component_of

MARGIN = 0.05  # m kept around the cuts while subdividing, so that the borders of the crop do not show


@dataclass(frozen=True, eq=False)
class HalfBody:
    """The left half, its mid-plane vertices and the rings of its areola."""

    surface: Surface
    middle: Booleans  # (V,) vertices on the mid-plane
    rings: list[Integers]  # vertices of the areola's border, then inwards, the tip last
    axis: Array  # (3,) direction in which the nipple points


def smooth_surface(source: Source, body: Array, recipe: dict[str, Any]) -> Surface:
    """The torso's neighbourhood of a body (S, 3), subdivided and triangulated."""
    low, high = np.array(recipe["crop"]["low"]) - MARGIN, np.array(recipe["crop"]["high"]) + MARGIN
    centre = body[source.quads].mean(axis=1)
    quads = source.quads[((centre > low) & (centre < high)).all(axis=1)]
    mix = sparse.identity(len(body), format="csr")
    for _ in range(recipe["crop"]["subdivisions"]):
        matrix, quads = subdivide(quads, mix.shape[0])
        mix = (matrix @ mix).tocsr()
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return compacted(Surface(mix @ body, triangles, mix), triangles)[0]


def _plane(points: Array, through: Array, normal: Array) -> Array:
    return np.asarray((points - through) @ (normal / np.linalg.norm(normal)))


def sizing_field(recipe: dict[str, Any]) -> Sizing:
    """The wished edge length: fine inside each named ball, growing with the distance from it."""
    balls = recipe["sizing"]["balls"]
    coarsest = recipe["sizing"]["coarsest"]

    def size(points: Array) -> Array:
        result = np.full(len(points), coarsest)
        for ball in balls:
            distance = np.linalg.norm(points - np.array(ball["centre"]), axis=1)
            result = np.minimum(result, ball["edge"] + ball["growth"] * np.clip(distance - ball["radius"], 0.0, None))
        return result

    return size


def half_body(source: Source, body: Array, recipe: dict[str, Any]) -> HalfBody:
    """The finished left half of the template."""
    smooth = smooth_surface(source, body, recipe)
    nipple = recipe["areola"]
    near_tip = np.linalg.norm(smooth.vertices - body[nipple["tip_vertex"]], axis=1)
    tip = smooth.vertices[near_tip.argmin()].copy()
    axis = nipple_axis(smooth, tip, nipple["axis_radius"])

    shoulder, elbow = source.joint("l-shoulder", body), source.joint("l-elbow", body)
    arm_at = shoulder + recipe["cuts"]["arm_share"] * (elbow - shoulder)
    tilt = np.radians(recipe["cuts"]["neck_tilt_deg"])
    labels: dict[str, Booleans] = {}
    surface = smooth
    surface, labels = clipped(surface, labels, "middle", surface.vertices[:, 0])
    waist = np.array([0.0, recipe["cuts"]["waist_height"], 0.0])
    surface, labels = clipped(surface, labels, "waist", _plane(surface.vertices, waist, np.array([0.0, 1.0, 0.0])))
    neck = np.array([0.0, recipe["cuts"]["neck_height"], 0.0])
    surface, labels = clipped(
        surface, labels, "neck", _plane(surface.vertices, neck, np.array([0.0, -np.cos(tilt), -np.sin(tilt)]))
    )
    across = _plane(surface.vertices, arm_at, shoulder - elbow)
    near_arm = np.linalg.norm(surface.vertices - arm_at, axis=1) < recipe["cuts"]["arm_reach"]
    surface, labels = clipped(surface, labels, "arm", np.where(near_arm, across, 1.0))
    beyond = distance_from_axis(surface.vertices, tip, axis) - nipple["radius"]
    near_nipple = np.linalg.norm(surface.vertices - tip, axis=1) < 2.0 * nipple["radius"]
    surface, labels = clipped(surface, labels, "areola", np.where(near_nipple, beyond, 1.0))
    inside = int(np.linalg.norm(surface.vertices - tip, axis=1).argmin())
    surface, used = compacted(surface, component_of(surface, inside))
    labels = {name: on[used] for name, on in labels.items()}

    fresh, on = remesh(surface, labels, sizing_field(recipe), recipe["sizing"]["rounds"])
    rings = [(float(r), int(n)) for r, n in nipple["rings"]]
    closed, ring_vertices = filled(fresh, np.flatnonzero(on["areola"]), smooth, tip, axis, rings)
    middle = np.zeros(len(closed.vertices), dtype=bool)
    middle[: len(fresh.vertices)] = on["middle"]
    return HalfBody(closed, middle, ring_vertices, axis)


__all__ = ["HalfBody", "axis_frame", "half_body", "sizing_field", "smooth_surface"]
