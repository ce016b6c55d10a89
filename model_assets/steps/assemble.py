"""All steps in order: source and recipe in, a complete Rig out."""

from typing import Any

import numpy as np

from breastrig.rig.model import Rig
from steps.breast import breast_fields
from steps.drawings import drawings
from steps.half_body import half_body, smooth_surface
from steps.landmarks import find_landmarks, landmarks
from steps.parameterise import flattened
from steps.regions import regions
from steps.shapes import blendshapes
from steps.skeleton import bones_and_joints, skin_weights
from steps.skin import Skin
from steps.source import Array, Source
from steps.whole_body import whole_body


def reference_body(source: Source, recipe: dict[str, Any]) -> Array:
    """(S, 3) m: the symmetric adult body that the template samples."""
    moved = sum((weight * source.target(name) for name, weight in recipe["body"]["targets"]), source.vertices)
    return source.symmetrised(np.asarray(moved))


def build_rig(source: Source, recipe: dict[str, Any]) -> Rig:
    """The torso."""
    body = reference_body(source, recipe)
    half = half_body(source, body, recipe)
    template = whole_body(half, source.mirror, recipe["decimals"])
    bones, joints = bones_and_joints(source, body, recipe)
    names = [bone.name for bone in bones]
    weights = np.round(skin_weights(source, template, names, recipe), recipe["decimals"])
    weights /= weights.sum(axis=1, keepdims=True)
    arm = weights[:, names.index("upper_arm_L")] + weights[:, names.index("upper_arm_R")]
    breast = breast_fields(template, arm, recipe)
    shapes, displacements = blendshapes(source, template, breast, arm, recipe)
    skin = Skin(template.vertices, template.triangles)
    fine = smooth_surface(source, body, recipe)
    marks = find_landmarks(
        skin, Skin(fine.vertices, fine.triangles), template, source.joint("l-shoulder", body), recipe["landmarks"]
    )
    return Rig(
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
    )
