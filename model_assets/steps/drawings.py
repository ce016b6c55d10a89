"""The drawings `lumpectomy`, `anatomy`, `mastectomy`: smooth lines of evenly spaced surface points on the template."""

from typing import Any

import numpy as np

from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rig.model import DrawnShape, ModelDrawing
from steps.areola import axis_frame
from steps.breast import Breast
from steps.skin import Skin
from steps.source import Array
from steps.whole_body import FLIP, Template

RIMS = {"areola_lower_L"}  # open lines that follow an edge of the model


def on_footprint(template: Template, b: Breast, angles: Array, radius: Array | float) -> Array:
    """(M, 3) m: points of the left breast at these polar coordinates of its footprint (angle rad, 0 lateral)."""
    t = template.triangles
    near = (b.radius[t] < 1.7).all(axis=1) & (b.mask[t] > 0.0).any(axis=1)
    t = t[near]
    flat = np.stack([b.lateral, b.upward], axis=1)
    a, u, w = flat[t[:, 0]], flat[t[:, 1]] - flat[t[:, 0]], flat[t[:, 2]] - flat[t[:, 0]]
    det = u[:, 0] * w[:, 1] - u[:, 1] * w[:, 0]
    safe = np.where(np.abs(det) > 1e-12, det, 1.0)
    points = []
    for angle, r in zip(angles, np.broadcast_to(radius, angles.shape), strict=True):
        p = r * np.array([np.cos(angle), np.sin(angle)]) - a
        s = (p[:, 0] * w[:, 1] - p[:, 1] * w[:, 0]) / safe
        q = (u[:, 0] * p[:, 1] - u[:, 1] * p[:, 0]) / safe
        outside = np.maximum(np.maximum(-s, -q), s + q - 1.0)
        best = int(np.where(np.abs(det) > 1e-12, outside, np.inf).argmin())
        share = np.array([1 - s[best] - q[best], s[best], q[best]])
        points.append(share @ template.vertices[t[best]])
    return np.array(points)


def _around(skin: Skin, angle: float, heights: Array, axis_z: float) -> Array:
    """(M, 3) m: the torso's wall seen from the spine under one angle (0 front, 90 degrees left) at these heights."""
    direction = np.array([np.sin(angle), 0.0, np.cos(angle)])
    return np.array([skin.ray(np.array([0.0, y, axis_z]), direction).points[0] for y in heights])


def _stewart(template: Template, b: Breast, r: dict[str, Any]) -> list[Array]:
    """Upper and lower edge (M, 3) m of Stewart's ellipse on the left breast, each from the medial to the lateral end.

    A spindle around the areola in the footprint's coordinates: it slants from low beside the sternum up towards
    the axilla, as the scar shall lie, and is as wide as closes without tension.
    """
    medial, lateral = (
        radius * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
        for angle, radius in (r["medial"], r["lateral"])
    )
    tip = template.rings[-1][0]
    nipple = np.array([b.lateral[tip], b.upward[tip]])
    axis = lateral - medial
    across = np.array([-axis[1], axis[0]]) / np.linalg.norm(axis)
    across *= np.sign(across[1])
    share = np.linspace(0.0, 1.0, 25)
    middle = float((nipple - medial) @ axis / (axis @ axis))
    bend = float((nipple - medial) @ across) * share * (1.0 - share) / (middle * (1.0 - middle))  # through the nipple
    width = np.sin(np.pi * share)
    edges = []
    for half in (r["half_width"], -r["half_width"]):
        flat = medial + share[:, None] * axis + (bend + half * width)[:, None] * across
        edges.append(on_footprint(template, b, np.arctan2(flat[:, 1], flat[:, 0]), np.linalg.norm(flat, axis=1)))
    return edges


def drawings(
    template: Template, b: Breast, skin: Skin, marks: dict[str, Array], recipe: dict[str, Any]
) -> tuple[ModelDrawing, ...]:
    """All drawings; the right side mirrors the left."""
    d = recipe["drawings"]
    spacing = d["spacing"]
    turn = np.linspace(0.0, 2 * np.pi, 49)[:-1]
    lines: dict[str, tuple[Array, bool]] = {}
    cornered = {"stewart": _stewart(template, b, d["stewart"])}
    notch, xiphoid, clavicle = marks["suprasternal_notch"], marks["xiphoid"], marks["midclavicle_L"]
    nipple, fold = marks["nipple_L"], marks["inframammary_fold_L"]
    beside = d["sternum_half_width"]

    def front(x: float, y: float) -> Array:
        return skin.ray(np.array([x, y, 0.5]), np.array([0.0, 0.0, -1.0])).points[0]

    left_upper = [front(x, notch[1] + d["upper_rise"] * (x / beside) ** 2) for x in np.linspace(0.0, beside, 7)]
    left_lower = [front(x, xiphoid[1] - d["lower_fall"] * (x / beside) ** 1.5) for x in np.linspace(0.0, beside, 7)]
    for name, half in (("sternum_upper", left_upper), ("sternum_lower", left_lower)):
        left = np.array(half)
        lines[name] = (np.concatenate([FLIP * left[:0:-1], left]), False)
    outline = on_footprint(template, b, turn, 1.0)
    lines["breast_L"] = (outline, True)
    below = np.linspace(np.radians(200.0), np.radians(345.0), 30)
    lines["fold_L"] = (on_footprint(template, b, below, 1.0), False)
    lowest = float(template.vertices[:, 1].min())
    ends = np.linspace(notch[1], lowest + 0.004, 60)
    lines["midline"] = (np.array([front(0.0, float(y)) for y in ends]), False)
    under = front(float(fold[0]), float(fold[1]) - d["meridian_below"])
    upper = np.array([front(*((1 - s) * clavicle + s * nipple)[:2]) for s in np.linspace(0.0, 1.0, 12)])
    lines["meridian_upper_L"] = (upper, False)
    lines["meridian_lower_L"] = (np.stack([nipple, fold, under]), False)
    heights = np.linspace(d["axillary_top"], lowest + 0.004, 30)
    lines["axillary_L"] = (_around(skin, np.radians(d["axillary_angle_deg"]), heights, 0.0), False)

    if "gland_radius" in d:
        at = template.rings[-1][0]
        flat = np.array([b.lateral[at], b.upward[at]]) + d["gland_radius"] * np.stack([np.cos(turn), np.sin(turn)], 1)
        outline = on_footprint(template, b, np.arctan2(flat[:, 1], flat[:, 0]), np.linalg.norm(flat, axis=1))
        lines["gland_L"] = (outline, True)
        border = template.vertices[template.rings[0]]
        side, up = axis_frame(b.axis)
        angle = np.arctan2((border - nipple) @ side, -((border - nipple) @ up))  # 0 straight below the nipple
        lower = np.abs(angle) <= 0.5 * np.pi
        lines["areola_lower_L"] = (border[lower][np.argsort(angle[lower], kind="stable")], False)

    fitted: dict[str, SurfacePoints] = {}
    result = []
    for drawing in d["list"]:
        shapes = []
        for entry in drawing["shapes"]:
            for side in ("_L", "_R") if entry.get("sided") else ("",):
                key = entry["line"] + ("_L" if side else "")
                flip = FLIP if side == "_R" else np.ones(3)
                corners: tuple[int, ...] = ()
                if entry["line"] in cornered:
                    edges = [skin.line(edge * flip, False, spacing, d["rounds"]) for edge in cornered[entry["line"]]]
                    fitted[key + side], corners = _joined(edges)
                    closed = True
                else:
                    anchors, closed = lines[key]
                if key + side not in fitted:
                    rounds = 0 if key in RIMS else d["rounds"]  # smoothing would draw an arc to its chord
                    fitted[key + side] = skin.line(anchors * flip, closed, spacing, rounds)
                    if key == "midline":
                        fitted[key] = skin.nearest_on_midline(skin.at(fitted[key]))
                words = {"_L": "left ", "_R": "right ", "": ""}[side]
                shapes.append(
                    DrawnShape(
                        entry["name"] + side,
                        words + entry["label"],
                        closed,
                        entry["color"],
                        fitted[key + side],
                        corners,
                    )
                )
        result.append(ModelDrawing(drawing["name"], drawing["label"], tuple(shapes)))
    return tuple(result)


def _joined(edges: list[SurfacePoints]) -> tuple[SurfacePoints, tuple[int, ...]]:
    """Two lines from one end to the other as one closed line that turns sharply at both ends, and those corners."""
    there, back = edges
    order = np.arange(len(back))[-2:0:-1]
    faces = np.concatenate([there.faces, back.faces[order]])
    return SurfacePoints(faces, np.concatenate([there.barycentric, back.barycentric[order]])), (0, len(there) - 1)
