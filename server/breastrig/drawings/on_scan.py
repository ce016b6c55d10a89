"""A drawing of the model, carried by the fitted model and laid on the scan.

Each polyline is resampled evenly on the posed model, then every point is shot along the model's normal, both
ways; the nearer hit on skin that faces the same way wins, else the closest such point, else the point stays
on the model and is marked as bridged (the scan has a hole there).  Points never leave the neighbourhood of
the model, so nothing jumps to the back, to the other breast or to the table.
"""

from dataclasses import dataclass

import numpy as np

from breastrig.core.arrays import Array, Booleans
from breastrig.correspondence.match import MatchRules, match
from breastrig.correspondence.target import ScanTarget
from breastrig.geometry.curves import resampled
from breastrig.geometry.normals import vertex_normals
from breastrig.rig.model import ModelDrawing, Rig

SPACING = 0.003  # m; finer than a pen, coarser than the noise
ON_SKIN = (
    MatchRules(method="rays", max_distance=0.03, max_angle=np.pi / 3),
    MatchRules(method="tree", max_distance=0.02, max_angle=np.pi / 3, candidates=16),
)


@dataclass(frozen=True, eq=False)
class ScanLine:
    """One polyline on the scan."""

    name: str
    closed: bool
    color: str
    points: Array  # (M, 3) m
    bridged: Booleans  # (M,) lies on the model because the scan has no skin there


def on_scan(rig: Rig, vertices: Array, drawing: ModelDrawing, target: ScanTarget) -> tuple[ScanLine, ...]:
    """The drawing on the scan, for (V, 3) m posed vertices in the target's frame."""
    normals = vertex_normals(vertices, rig.faces)
    lines = []
    for shape in drawing.shapes:
        at = shape.points.positions(vertices, rig.faces)
        facing = shape.points.positions(normals, rig.faces)
        even = resampled(np.concatenate([at, facing], axis=1), SPACING, shape.closed)
        points = even[:, :3].copy()
        directions = even[:, 3:] / np.maximum(np.linalg.norm(even[:, 3:], axis=1, keepdims=True), 1e-12)
        missing = np.arange(len(points))
        for rules in ON_SKIN:
            found = match(target, even[missing, :3], directions[missing], rules)
            points[missing[found.vertices]] = found.points
            missing = np.delete(missing, found.vertices)
        bridged = np.zeros(len(points), dtype=np.bool_)
        bridged[missing] = True
        lines.append(ScanLine(shape.name, shape.closed, shape.color, points, bridged))
    return tuple(lines)
