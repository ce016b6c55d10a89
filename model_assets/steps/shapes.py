"""The 55 blendshapes in the recipe's order, left and right apart where they have sides."""

from typing import Any

import numpy as np

from breastrig.rig.model import Shape
from steps.body_shapes import BODY_SHAPES, sculpted, side_mask
from steps.breast import Breast
from steps.breast_shapes import BREAST_SHAPES
from steps.operators import laplacian, smoothed
from steps.skeleton import mirror_name
from steps.source import Array, Source
from steps.whole_body import Template


def _raw(source: Source, template: Template, breast: Breast, arm: Array, entry: dict[str, Any]) -> Array:
    total = np.zeros_like(template.vertices)
    if "targets" in entry:
        total += sculpted(source, template, entry["targets"])
    for part in entry.get("make", []):
        kind = part["kind"]
        if kind in BREAST_SHAPES:
            total += BREAST_SHAPES[kind](template, breast, part)
        else:
            total += BODY_SHAPES[kind](template, arm, part)
    return total


def blendshapes(
    source: Source, template: Template, breast: Breast, arm: Array, recipe: dict[str, Any]
) -> tuple[tuple[Shape, ...], Array]:
    """(what is known of each shape, (S, V, 3) m displacements)."""
    stiffness, area = laplacian(template.vertices, template.triangles)
    known: list[Shape] = []
    fields: list[Array] = []
    for entry in recipe["shapes"]:
        field = _raw(source, template, breast, arm, entry)
        if "smooth" in entry:
            field = smoothed(field, stiffness, area, entry["smooth"])
        if entry.get("sided"):
            mask = side_mask(template, recipe["side_half_width"])
            left = field * mask[:, None] if "targets" in entry else field
            pairs = [("_L", left, "left "), ("_R", template.mirrored(left), "right ")]
        else:
            pairs = [("", template.symmetric(field), "")]
        for suffix, displacement, side in pairs:
            name = entry["name"] + suffix
            known.append(
                Shape(
                    name, entry["kind"], float(entry["min"]), float(entry["max"]), float(entry["sigma"]),
                    mirror_name(name), side + entry["label"],
                )
            )  # fmt: skip
            fields.append(displacement)
    return tuple(known), np.round(np.array(fields), recipe["decimals"])
