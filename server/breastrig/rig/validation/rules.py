"""The proof that a rig is sound: every rule of the contract, ours or anybody's, with what was found.

Its other parts are mesh.py, drawings.py and symmetry.py.  Nothing raises: a broken rig gives findings, so that its
maker sees all of them at once.
"""

import re
from collections import Counter

import numpy as np

from breastrig.core.arrays import Array, Integers
from breastrig.rig.model import LEAST_GAP, Rig
from breastrig.rig.validation.drawings import drawing_findings, on_triangle
from breastrig.rig.validation.finding import Finding, named
from breastrig.rig.validation.mesh import mesh_findings
from breastrig.rig.validation.symmetry import other_side, symmetry_findings

__all__ = ["Finding", "check_rig", "describe_rig"]

NAME = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*(_[LR])?")
INFLUENCES = 4
SUM_TOLERANCE = 1e-6
SMOOTH_WEIGHTS = 0.6  # largest change of a skin weight along one edge
SMALLEST, LARGEST = 0.02, 2.5  # m, the longest side of a template: a thumb, and a man with his arms spread
UNITS = {"centimetres": 1e-2, "millimetres": 1e-3, "inches": 0.0254, "decimetres": 0.1, "feet": 0.3048}
KINDS = ("body", "soft", "gravity")


def check_rig(rig: Rig) -> list[Finding]:
    """The finding of each rule; where the arrays do not fit together only the first rules are checked."""
    findings = [_sizes(rig)]
    if findings[0].ok:
        findings += [_finite(rig), _indices(rig)]
    if not all(finding.ok for finding in findings):
        return findings
    findings += [_length(rig), *mesh_findings(rig)]
    findings += [_weight_sums(rig), _influences(rig), _smooth_weights(rig)]
    findings += [
        _bones(rig),
        _rest_frames(rig),
        _joints(rig),
        _names(rig),
        _ranges(rig),
        _joints_give(rig),
        _useful_shapes(rig),
    ]
    findings += [
        _landmarks(rig),
        _left_and_right(rig),
        *drawing_findings(rig),
        _regions(rig),
        *symmetry_findings(rig),
    ]
    return findings


def describe_rig(rig: Rig) -> str:
    """A summary of the rig's contents, for people."""
    size = np.ptp(rig.template, axis=0)
    kinds = Counter(shape.kind for shape in rig.shapes)
    width = max([len(name) for name in (*rig.bone_names, *rig.shape_names, *rig.landmark_names)], default=0)
    lines = [
        f"{rig.name}  (sha256 {rig.sha256})",
        f"{len(rig.template)} vertices, {len(rig.faces)} triangles, "
        f"{1e3 * size[0]:.0f} x {1e3 * size[1]:.0f} x {1e3 * size[2]:.0f} mm",
        "",
        f"{len(rig.bones)} bones, {len(rig.joints)} joints",
    ]
    for bone in rig.bones:
        parent = "root" if bone.parent is None else rig.bones[bone.parent].name
        limits = " ".join(f"{a:.2f}-{b:.2f}" for a, b in zip(bone.scale_min, bone.scale_max, strict=True))
        lines.append(f"  {bone.name:{width}}  on {parent}, scale {limits}")
    counted = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
    lines += ["", f"{len(rig.shapes)} shapes" + (f" ({counted})" if counted else "")]
    reach = 1e3 * np.linalg.norm(rig.blendshapes, axis=2).max(axis=1, initial=0.0)
    for shape, most in zip(rig.shapes, reach, strict=True):
        lines.append(f"  {shape.name:{width}}  {shape.kind:7}  {shape.min:g} to {shape.max:g}, {most:.1f} mm at 1")
    lines += ["", f"{len(rig.landmarks)} landmarks"]
    lines += [f"  {landmark.name:{width}}  {landmark.label}" for landmark in rig.landmarks]
    lines += ["", f"{len(rig.drawings)} drawings"]
    lines += [f"  {drawing.name}: {', '.join(shape.name for shape in drawing.shapes)}" for drawing in rig.drawings]
    return "\n".join(lines)


def _sizes(rig: Rig) -> Finding:
    count, bones, shapes = len(rig.template), len(rig.bones), len(rig.shapes)
    wanted: dict[str, tuple[Array | Integers, tuple[int, ...]]] = {
        "template": (rig.template, (count, 3)),
        "triangles": (rig.faces, (len(rig.faces), 3)),
        "texture coordinates": (rig.uv, (count, 2)),
        "shapes": (rig.blendshapes, (shapes, count, 3)),
        "skin weights": (rig.skin_weights, (count, bones)),
        "mirror map": (rig.mirror_vertices, (count,)),
    }
    wrong = [
        f"{name} {array.shape} instead of {shape}" for name, (array, shape) in wanted.items() if array.shape != shape
    ]
    empty = count == 0 or len(rig.faces) == 0 or bones == 0
    detail = f"{named(wrong)}." if wrong else "there are no vertices, triangles or bones." if empty else "all agree"
    return Finding("the parts fit together", not wrong and not empty, detail)


def _finite(rig: Rig) -> Finding:
    arrays = {
        "template": rig.template,
        "texture coordinates": rig.uv,
        "shapes": rig.blendshapes,
        "skin weights": rig.skin_weights,
        "bones": np.array(
            [[*bone.origin, *bone.rotation.ravel(), *bone.scale_min, *bone.scale_max] for bone in rig.bones]
        ),
        "joints": np.array([joint.anchor for joint in rig.joints]),
    }
    wrong = [name for name, array in arrays.items() if not np.isfinite(array).all()]
    return Finding("all numbers are finite", not wrong, f"not finite: {named(wrong)}." if wrong else "all of them")


def _length(rig: Rig) -> Finding:
    longest = float(np.ptp(rig.template, axis=0).max())
    name = "the size is that of a body or a part of one"
    if SMALLEST <= longest <= LARGEST:
        return Finding(name, True, f"{longest:.2f} m long")
    units = [unit for unit, metres in UNITS.items() if SMALLEST <= metres * longest <= LARGEST]
    perhaps = f"are these {' or '.join(units[:2])}? " if units else ""
    detail = (
        f"it is {longest:.3g} m long; {perhaps}glTF is in metres: scale mesh, bones and side file, and export again."
    )
    return Finding(name, False, detail)


def _left_and_right(rig: Rig) -> Finding:
    """Checks that _L lies on the patient's left, +X, of its partner _R: bones, shapes, landmarks, regions and lines."""
    name = "left is the patient's left, on +X"
    moved = np.linalg.norm(rig.blendshapes, axis=2)
    shares = moved / np.maximum(moved.sum(axis=1, keepdims=True), 1e-12)
    places = rig.landmark_points().positions(rig.template, rig.faces) if rig.landmarks else np.zeros((0, 3))
    across: dict[str, dict[str, float]] = {
        "bone": {bone.name: float(bone.origin[0]) for bone in rig.bones},
        "shape": dict(zip(rig.shape_names, (shares @ rig.template[:, 0]).tolist(), strict=True)),
        "landmark": dict(zip(rig.landmark_names, places[:, 0].tolist(), strict=True)),
        "region": {each: float(rig.template[chosen, 0].mean()) for each, chosen in rig.regions.items() if len(chosen)},
    }
    for drawing in rig.drawings:
        lines = {shape.name: shape.points.positions(rig.template, rig.faces)[:, 0].mean() for shape in drawing.shapes}
        across[f"line of {drawing.name}"] = {each: float(x) for each, x in lines.items()}
    pairs = [
        (kind, each, xs[each] - xs[other_side(each)])
        for kind, xs in across.items()
        for each in xs
        if each.endswith("_L") and other_side(each) in xs
    ]
    wrong = [f"{kind} {each}" for kind, each, apart in pairs if apart <= 0.0]
    if not wrong:
        return Finding(name, True, f"{len(pairs)} pairs")
    return Finding(name, False, f"exchanged with the partner: {named(wrong)}; exchange their names, or mirror the rig.")


def _indices(rig: Rig) -> Finding:
    count, bones = len(rig.template), len(rig.bones)
    wrong = []
    if rig.faces.min() < 0 or rig.faces.max() >= count:
        wrong.append("triangles")
    elif (rig.faces == np.roll(rig.faces, 1, axis=1)).any():
        wrong.append("triangles (a corner is named twice)")
    if rig.mirror_vertices.min() < 0 or rig.mirror_vertices.max() >= count:
        wrong.append("mirror map")
    if any(not 0 <= index < bones for joint in rig.joints for index in (joint.parent, joint.child)):
        wrong.append("joints")
    if any(bone.parent is not None and not 0 <= bone.parent < bones for bone in rig.bones):
        wrong.append("parents of bones")
    wrong += [f"region {name}" for name, chosen in rig.regions.items() if ((chosen < 0) | (chosen >= count)).any()]
    wrong += [f"landmark {mark.name}" for mark in rig.landmarks if not 0 <= mark.face < len(rig.faces)]
    for drawing in rig.drawings:
        for shape in drawing.shapes:
            if ((shape.points.faces < 0) | (shape.points.faces >= len(rig.faces))).any():
                wrong.append(f"line {shape.name} of {drawing.name}")
    detail = f"they name things that are not there: {named(wrong)}." if wrong else "all in range"
    return Finding("indices are in range", not wrong, detail)


def _weight_sums(rig: Rig) -> Finding:
    worst = float(np.abs(rig.skin_weights.sum(axis=1) - 1.0).max())
    lowest = float(rig.skin_weights.min())
    detail = f"within {worst:.1e}" if lowest >= 0 else f"the smallest is {lowest:.3f}; weights must not be negative."
    if worst > SUM_TOLERANCE:
        detail = f"a row misses 1 by {worst:.4f}."
    return Finding("skin weights sum to 1", worst <= SUM_TOLERANCE and lowest >= 0, detail)


def _influences(rig: Rig) -> Finding:
    most = int((rig.skin_weights != 0).sum(axis=1).max())
    return Finding("at most four bones hold a vertex", most <= INFLUENCES, f"at most {most}")


def _smooth_weights(rig: Rig) -> Finding:
    edges = np.concatenate([rig.faces[:, [0, 1]], rig.faces[:, [1, 2]], rig.faces[:, [2, 0]]])
    jump = float(np.abs(rig.skin_weights[edges[:, 0]] - rig.skin_weights[edges[:, 1]]).max())
    detail = f"at most {jump:.2f} from one vertex to the next"
    return Finding("skin weights are smooth", jump <= SMOOTH_WEIGHTS, detail, "advice")


def _bones(rig: Rig) -> Finding:
    name = "bones form one tree, parents first"
    roots = [bone.name for bone in rig.bones if bone.parent is None]
    late = [bone.name for index, bone in enumerate(rig.bones) if bone.parent is not None and bone.parent >= index]
    if late:
        return Finding(name, False, f"these stand before their parent: {named(late)}.")
    if len(roots) != 1:
        return Finding(name, False, f"there must be one root, there are {len(roots)}: {named(roots)}.")
    return Finding(name, True, f"{len(rig.bones)} bones on {roots[0]}")


def _rest_frames(rig: Rig) -> Finding:
    wrong = [
        bone.name
        for bone in rig.bones
        if np.abs(bone.rotation.T @ bone.rotation - np.eye(3)).max() > 1e-6 or np.linalg.det(bone.rotation) < 0
    ]
    detail = f"scaled, sheared or mirrored: {named(wrong)}." if wrong else "orthonormal and right-handed"
    return Finding("rest frames are rotations", not wrong, detail)


def _joints(rig: Rig) -> Finding:
    """Checks that the joints form a tree over all bones: one fewer than bones, without rings."""
    name = "joints link all bones to a tree"
    group = list(range(len(rig.bones)))
    for joint in rig.joints:
        parent, child = group[joint.parent], group[joint.child]
        if parent == child:
            return Finding(name, False, f"the joint at {rig.bones[joint.child].name} closes a ring.")
        group = [parent if member == child else member for member in group]
    loose = sorted({rig.bones[index].name for index, member in enumerate(group) if member != group[0]})
    detail = f"not linked to {rig.bones[0].name}: {named(loose)}." if loose else f"{len(rig.joints)} joints"
    return Finding(name, not loose, detail)


def _names(rig: Rig) -> Finding:
    lists: dict[str, list[str]] = {
        "bones": list(rig.bone_names),
        "shapes": list(rig.shape_names),
        "landmarks": list(rig.landmark_names),
        "drawings": list(rig.drawing_names),
        **{f"lines of {drawing.name}": [shape.name for shape in drawing.shapes] for drawing in rig.drawings},
    }
    wrong = [f'"{name}"' for names in lists.values() for name in names if not NAME.fullmatch(name)]
    wrong += [f"{what}: {name} twice" for what, names in lists.items() for name, n in Counter(names).items() if n > 1]
    detail = f"{named(wrong)}: use lower case, digits and underscores, _L and _R for sides." if wrong else "all good"
    return Finding("names are unique, lower case, without dots", not wrong, detail)


def _ranges(rig: Rig) -> Finding:
    wrong = [shape.name for shape in rig.shapes if not (shape.min <= 0 <= shape.max and shape.min < shape.max)]
    wrong += [shape.name for shape in rig.shapes if shape.sigma <= 0 or shape.kind not in KINDS]
    for bone in rig.bones:
        if not ((bone.scale_min > 0) & (bone.scale_min <= 1) & (bone.scale_max >= 1)).all():
            wrong.append(bone.name)
    for joint in rig.joints:
        if joint.rotation_sigma <= 0 or joint.translation_sigma < 0 or joint.rotation_limit <= 0:
            wrong.append(f"the joint at {rig.bones[joint.child].name}")
    detail = "they must hold rest (weight 0, scale 1) and have a size: " + named(wrong) if wrong else "all hold rest"
    return Finding("ranges and sizes make sense", not wrong, detail)


def _joints_give(rig: Rig) -> Finding:
    stiff = [rig.bones[joint.child].name for joint in rig.joints if joint.translation_sigma < LEAST_GAP]
    least = f"{1e3 * LEAST_GAP:g} mm"
    detail = f"{named(stiff)}: a fit expects gaps of {least} there." if stiff else f"at least {least}"
    return Finding("joints give a little", not stiff, detail, "advice")


def _useful_shapes(rig: Rig) -> Finding:
    """Checks that every shape moves something, and that no two are the same up to a factor."""
    flat = rig.blendshapes.reshape(len(rig.shapes), len(rig.template) * 3)
    sizes = np.linalg.norm(flat, axis=1)
    idle = [shape.name for shape, size in zip(rig.shapes, sizes, strict=True) if size < 1e-6]
    unit = flat / np.maximum(sizes, 1e-12)[:, None]
    alike = np.triu(np.abs(unit @ unit.T), 1) > 0.999
    twins = [f"{rig.shapes[i].name} = {rig.shapes[j].name}" for i, j in np.argwhere(alike)]
    wrong = [*(f"{name} moves nothing" for name in idle), *twins]
    return Finding("every shape does something of its own", not wrong, f"{named(wrong)}." if wrong else "all of them")


def _landmarks(rig: Rig) -> Finding:
    wrong = [mark.name for mark in rig.landmarks if not on_triangle(mark.barycentric)]
    wrong += [f"{mark.name} has no definition" for mark in rig.landmarks if not mark.definition or not mark.label]
    detail = f"not inside its triangle or not explained: {named(wrong)}." if wrong else f"{len(rig.landmarks)}"
    return Finding("landmarks lie on the surface and are explained", not wrong, detail)


def _regions(rig: Rig) -> Finding:
    wrong = [name for name, chosen in rig.regions.items() if len(chosen) == 0 or len(np.unique(chosen)) != len(chosen)]
    detail = f"empty or with repeated vertices: {named(wrong)}." if wrong else f"{len(rig.regions)} regions"
    return Finding("regions name vertices once", not wrong, detail)
