"""Rules for left and right: the mirror maps lead back, and what they pair is one another's mirror image.

A rig of a body part without symmetry says so by mapping every vertex to itself; then only the maps are checked.
"""

from collections.abc import Sequence
from typing import Literal

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.rig.model import Bone, Landmark, Rig, Shape
from breastrig.rig.validation.finding import Finding, named

TOLERANCE = 1e-5  # m, 0.01 mm
WEIGHT_TOLERANCE = 1e-4  # skin weights travel as float32, limits as decimals
FLIP = np.array([-1.0, 1.0, 1.0])


def is_symmetric(rig: Rig) -> bool:
    """Whether the rig claims a left and a right."""
    return bool((rig.mirror_vertices != np.arange(len(rig.template))).any())


def symmetry_findings(rig: Rig) -> list[Finding]:
    """Findings on left and right; requires indices in range."""
    findings = [_vertex_map(rig), *(_name_map(what, things) for what, things in _named_things(rig))]
    if not is_symmetric(rig):
        return [*findings, Finding("left and right", True, "the rig claims no symmetry")]
    if not all(finding.ok for finding in findings):
        return findings
    return [*findings, _template(rig), _triangles(rig), _weights(rig), _shapes(rig), _bones(rig), _landmarks(rig)]


def other_side(name: str) -> str:
    """The name of the partner: breast_L for breast_R, itself for a name without side."""
    return name[:-1] + {"L": "R", "R": "L"}[name[-1]] if name.endswith(("_L", "_R")) else name


def _named_things(rig: Rig) -> list[tuple[str, Sequence[Bone | Shape | Landmark]]]:
    return [("bones", rig.bones), ("shapes", rig.shapes), ("landmarks", rig.landmarks)]


def _vertex_map(rig: Rig) -> Finding:
    wrong = int((rig.mirror_vertices[rig.mirror_vertices] != np.arange(len(rig.template))).sum())
    detail = f"{wrong} vertices are not the partner of their partner." if wrong else "every partner leads back"
    return Finding("the mirror map of vertices leads back", wrong == 0, detail)


def _name_map(what: str, things: Sequence[Bone | Shape | Landmark]) -> Finding:
    mirror = {thing.name: thing.mirror for thing in things}
    wrong = [name for name, partner in mirror.items() if mirror.get(partner) != name]
    wrong += [name for name, partner in mirror.items() if name not in wrong and partner != other_side(name)]
    detail = f"{named(wrong)}: the partner must lead back, and _L must meet _R." if wrong else f"{len(things)} {what}"
    return Finding(f"the mirror map of {what} leads back", not wrong, detail)


def _worst(
    name: str, gaps: Array, culprits: list[str] | None = None, severity: Literal["error", "advice"] = "error"
) -> Finding:
    worst = int(gaps.argmax())
    gap = float(gaps[worst])
    detail = f"within {1e3 * gap:.4f} mm"
    if gap > TOLERANCE:
        culprit = culprits[worst] if culprits else f"vertex {worst}"
        detail = f"{culprit} is {1e3 * gap:.3f} mm away from its partner's mirror image."
    return Finding(name, gap <= TOLERANCE, detail, severity)


def _template(rig: Rig) -> Finding:
    gaps = np.linalg.norm(rig.template - FLIP * rig.template[rig.mirror_vertices], axis=1)
    return _worst("the template is symmetric", gaps)


def _triangles(rig: Rig) -> Finding:
    name = "the triangles are symmetric"

    def normal_form(faces: Integers) -> set[tuple[int, ...]]:
        first = faces.argmin(axis=1)
        return {tuple(np.roll(face, -k)) for face, k in zip(faces.tolist(), first.tolist(), strict=True)}

    own = normal_form(rig.faces)
    missing = len(own - normal_form(rig.mirror_vertices[rig.faces[:, ::-1]]))
    detail = f"{missing} triangles have no partner on the other side." if missing else f"{len(own)} triangles"
    return Finding(name, missing == 0, detail)


def _weights(rig: Rig) -> Finding:
    partner = [rig.bone_names.index(bone.mirror) for bone in rig.bones]
    gaps = np.abs(rig.skin_weights - rig.skin_weights[rig.mirror_vertices][:, partner])
    worst = float(gaps.max())
    detail = f"within {worst:.1e}"
    if worst > WEIGHT_TOLERANCE:
        vertex, bone = np.unravel_index(int(gaps.argmax()), gaps.shape)
        detail = f"vertex {vertex} and its partner differ by {worst:.3f} for {rig.bone_names[bone]}."
    return Finding("the skin weights are symmetric", worst <= WEIGHT_TOLERANCE, detail)


def _shapes(rig: Rig) -> Finding:
    wrong = []
    for shape, displacement in zip(rig.shapes, rig.blendshapes, strict=True):
        partner = rig.shapes[rig.shape_names.index(shape.mirror)]
        other = rig.blendshapes[rig.shape_names.index(shape.mirror)]
        gap = float(np.linalg.norm(displacement - FLIP * other[rig.mirror_vertices], axis=1).max())
        if gap > TOLERANCE:
            wrong.append(f"{shape.name} ({1e3 * gap:.2f} mm)")
        elif (shape.min, shape.max, shape.sigma, shape.kind) != (partner.min, partner.max, partner.sigma, partner.kind):
            wrong.append(f"{shape.name} (its partner has another range, size or kind)")
    detail = f"not the mirror image of the partner: {named(wrong)}." if wrong else f"{len(rig.shapes)} shapes"
    return Finding("the shapes are symmetric", not wrong, detail)


def _bones(rig: Rig) -> Finding:
    """Origins mirror; axes mirror up to their sign, since a reflected frame is no rotation."""
    wrong = []
    for bone in rig.bones:
        partner = rig.bones[rig.bone_names.index(bone.mirror)]
        axes = np.abs(bone.rotation.T @ (FLIP[:, None] * partner.rotation))
        limits = np.concatenate([bone.scale_min - partner.scale_min, bone.scale_max - partner.scale_max])
        far = np.linalg.norm(bone.origin - FLIP * partner.origin) > TOLERANCE
        if far or np.abs(axes - np.eye(3)).max() > WEIGHT_TOLERANCE or np.abs(limits).max() > WEIGHT_TOLERANCE:
            wrong.append(bone.name)
    anchors = {(rig.bone_names[joint.parent], rig.bone_names[joint.child]): joint.anchor for joint in rig.joints}
    for (parent, child), anchor in anchors.items():
        pair = (rig.bones[rig.bone_names.index(parent)].mirror, rig.bones[rig.bone_names.index(child)].mirror)
        if pair not in anchors or np.linalg.norm(anchor - FLIP * anchors[pair]) > TOLERANCE:
            wrong.append(f"the joint {parent} - {child}")
    detail = f"frame, limits or anchor differ from the partner's: {named(wrong)}." if wrong else "frames and anchors"
    return Finding("bones and joints are symmetric", not wrong, detail)


def _landmarks(rig: Rig) -> Finding:
    if not rig.landmarks:
        return Finding("the landmarks are symmetric", True, "there are none")
    places = rig.landmark_points().positions(rig.template, rig.faces)
    partner = [rig.landmark_names.index(landmark.mirror) for landmark in rig.landmarks]
    gaps = np.linalg.norm(places - FLIP * places[partner], axis=1)
    return _worst("the landmarks are symmetric", gaps, [f"landmark {name}" for name in rig.landmark_names], "advice")
