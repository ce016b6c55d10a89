"""A fit's .glb with a plan on it: its lines, and its lesions as balls with their numbers in the extras."""

from collections.abc import Mapping, Sequence
from typing import Any

from breastrig.core.srgb import rgb
from breastrig.drawings.drawing_file import lesions_on_scan, planned_on_scan
from breastrig.drawings.inks import LESION
from breastrig.geometry.polyline import Polyline
from breastrig.gltf.lines.lines_glb import Ball, with_lines

SAID = ("id", "name", "radius_mm", "error_mm", "ellipsoid_mm", "depth_mm", "carried")  # of a lesion


def planned_glb(fitted: bytes, plan: Mapping[str, Any], own: Sequence[Polyline] = ()) -> bytes:
    """`plan` is a document of `plan_document`, `own` what else is drawn, in m."""
    lines = [(line.name, line.points, line.closed, rgb(line.color)) for line in (*own, *planned_on_scan(dict(plan)))]
    balls = [
        Ball(
            f"lesion_{each['name']}", center, radius, rgb(LESION), {"kind": "lesion"} | {key: each[key] for key in SAID}
        )
        for each, center, radius in lesions_on_scan(plan)
    ]
    return with_lines(fitted, lines, balls)
