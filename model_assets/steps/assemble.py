"""All steps in order: source and recipe in, a complete Rig out."""

from dataclasses import replace
from typing import Any

import numpy as np

from breastrig.rig.model import Length, Rig
from steps.breast import Breast, breast_fields
from steps.breast_shapes import BREAST_SHAPES
from steps.drawings import drawings
from steps.frame import frame, reference_body
from steps.half_body import half_body, smooth_surface
from steps.landmarks import find_landmarks, landmarks, with_hanging_arms
from steps.parameterise import flattened
from steps.regions import regions
from steps.shapes import blendshapes
from steps.skeleton import bones_and_joints, skin_weights
from steps.skin import Skin
from steps.source import Array, Source
from steps.whole_body import Template, whole_body


def rounded(template: Template, breast: Breast, recipe: dict[str, Any]) -> Array:
    """(V, 3) m: what makes the reference's conical breasts rounder, on both sides."""
    left = sum(
        (part["weight"] * BREAST_SHAPES[part["kind"]](template, breast, part) for part in recipe["body"]["rounding"]),
        np.zeros_like(template.vertices),
    )
    return np.asarray(left + template.mirrored(left))


def carried(field: Array, template: Template, points: Array) -> Array:
    """A (V, 3) field of the template at (M, 3) points near it."""
    near = Skin(template.vertices, template.triangles).nearest(points)
    return near.positions(field, template.triangles)


def build_rig(source: Source, recipe: dict[str, Any]) -> Rig:
    """The torso: built in the frame of the recipe's lengths, then made as large as its body is."""
    own = frame(source, recipe)
    source = own.of_source(source)
    body = reference_body(source, recipe["body"]["targets"])
    half = half_body(source, body, recipe)
    template = whole_body(half, source.mirror, recipe["decimals"])
    bones, joints = bones_and_joints(source, body, recipe)
    names = [bone.name for bone in bones]
    weights = skin_weights(source, template, names, recipe)
    arms = weights[:, names.index("upper_arm_L")], weights[:, names.index("upper_arm_R")]
    arm = arms[0] + arms[1]
    rounding = rounded(template, breast_fields(template, arm, recipe), recipe)
    fine = smooth_surface(source, body, recipe)
    fine_skin = Skin(fine.vertices + carried(rounding, template, fine.vertices), fine.triangles)
    template = replace(template, vertices=np.round(template.vertices + rounding, recipe["decimals"]))
    breast = breast_fields(template, arm, recipe)
    shapes, displacements = blendshapes(source, template, breast, arm, recipe)
    skin = Skin(template.vertices, template.triangles)
    shoulder = source.joint("l-shoulder", body)
    standing = with_hanging_arms(template, arms, shoulder, np.radians(recipe["landmarks"]["arms_lowered_degrees"]))
    marks = find_landmarks(skin, fine_skin, standing, template, shoulder, recipe["landmarks"])
    built = Rig(
        name=recipe["name"],
        template=template.vertices,
        faces=template.triangles,
        uv=np.round(flattened(template.vertices, template.triangles), recipe["decimals"]),
        blendshapes=displacements,
        skin_weights=weights,
        bones=bones,
        joints=joints,
        shapes=shapes,
        landmarks=landmarks(marks, skin, recipe),
        drawings=drawings(template, breast, skin, marks, recipe),
        mirror_vertices=template.mirror,
        regions=regions(template, breast, weights, names, recipe),
        sha256="",
        lengths=tuple(Length(each["name"], each["label"], each["from"], each["to"]) for each in recipe["lengths"]),
    )
    return own.of_rig(built, recipe["decimals"])
