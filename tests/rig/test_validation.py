"""Each rule is broken once on a copy of the toy rig and must be the one that says so."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from breastrig.geometry.surface_points import SurfacePoints
from breastrig.rig.model import DrawnShape, Landmark, ModelDrawing, Rig
from breastrig.rig.validation.rules import Finding, check_rig, describe_rig
from breastrig.rig.validation.symmetry import other_side

Breaking = Callable[[Rig], Rig]


def broken_rules(rig: Rig) -> dict[str, Finding]:
    return {finding.name: finding for finding in check_rig(rig) if not finding.ok}


def changed(array: np.ndarray, index: object, value: object) -> np.ndarray:
    result = array.copy()
    result[index] = value
    return result


def with_bone(rig: Rig, index: int, **fields: object) -> Rig:
    return replace(rig, bones=(*rig.bones[:index], replace(rig.bones[index], **fields), *rig.bones[index + 1 :]))


def with_shape(rig: Rig, index: int, **fields: object) -> Rig:
    return replace(rig, shapes=(*rig.shapes[:index], replace(rig.shapes[index], **fields), *rig.shapes[index + 1 :]))


def with_landmark(rig: Rig, **fields: object) -> Rig:
    return replace(rig, landmarks=(replace(rig.landmarks[0], **fields), *rig.landmarks[1:]))


def with_line(rig: Rig, points: SurfacePoints) -> Rig:
    line = DrawnShape("line", "Line", False, "#000000", points)
    return replace(rig, drawings=(ModelDrawing("drawing", "Drawing", (line,)),))


def with_first_line(rig: Rig, **fields: object) -> Rig:
    drawing = rig.drawings[0]
    shapes = (replace(drawing.shapes[0], **fields), *drawing.shapes[1:])
    return replace(rig, drawings=(replace(drawing, shapes=shapes),))


def there_and_back(rig: Rig) -> SurfacePoints:
    points = rig.drawings[0].shapes[0].points
    order = np.r_[np.arange(len(points)), np.arange(len(points))[::-1]]
    return SurfacePoints(points.faces[order], points.barycentric[order])


def with_sides(rig: Rig, points: SurfacePoints) -> Rig:
    """The left breast's line once more under the right one's name."""
    left = rig.drawings[0].shapes[1]
    return replace(rig, drawings=(ModelDrawing("drawing", "", (left, replace(left, name="breast_R", points=points))),))


def with_extra_faces(rig: Rig, faces: list[list[int]], vertices: list[list[float]] | None = None) -> Rig:
    """More vertices on no bone of their own: everything else grows along."""
    more = 0 if vertices is None else len(vertices)
    grown = {
        "template": np.concatenate([rig.template, np.reshape(vertices or [], (more, 3))]),
        "uv": np.concatenate([rig.uv, np.zeros((more, 2))]),
        "blendshapes": np.concatenate([rig.blendshapes, np.zeros((len(rig.shapes), more, 3))], axis=1),
        "skin_weights": np.concatenate([rig.skin_weights, np.tile(rig.skin_weights[:1], (more, 1))]),
        "mirror_vertices": np.concatenate([rig.mirror_vertices, len(rig.template) + np.arange(more)]),
        "faces": np.concatenate([rig.faces, np.reshape(faces, (-1, 3))]).astype(np.int64),
    }
    return replace(rig, **grown)


def jagged(rig: Rig) -> Rig:
    """Every second vertex of the lowest ring is pulled down."""
    lowest = np.flatnonzero(rig.template[:, 1] < 1e-9)[::2]
    return replace(rig, template=changed(rig.template, (lowest, 1), -0.1))


def five_bones_on_one_vertex(rig: Rig) -> Rig:
    bones = (*rig.bones, replace(rig.bones[0], name="tail", mirror="tail", parent=0))
    weights = np.concatenate([rig.skin_weights, np.zeros((len(rig.template), 1))], axis=1)
    weights[0] = 0.2
    joint = replace(rig.joints[0], child=4)
    return replace(rig, bones=bones, skin_weights=weights, joints=(*rig.joints, joint))


def torn_weights(rig: Rig) -> Rig:
    upper = rig.template[:, 1] > 0.25
    weights = np.zeros_like(rig.skin_weights)
    weights[upper, 1], weights[~upper, 0] = 1.0, 1.0
    return replace(rig, skin_weights=weights)


def swapped_parent(rig: Rig) -> Rig:
    return with_bone(with_bone(rig, 0, parent=1), 1, parent=None)


def lopsided(rig: Rig) -> Rig:
    return replace(rig, template=changed(rig.template, (40, 0), rig.template[40, 0] + 2e-5))


def uneven_weights(rig: Rig) -> Rig:
    vertex = int(np.flatnonzero(rig.template[:, 0] > 0.1)[100 // 12])
    return replace(rig, skin_weights=changed(rig.skin_weights, vertex, [0.5, 0.5, 0.0, 0.0]))


def scaled(rig: Rig, factor: float) -> Rig:
    """Exported in another unit."""
    bones = tuple(replace(bone, origin=factor * bone.origin) for bone in rig.bones)
    return replace(rig, template=factor * rig.template, blendshapes=factor * rig.blendshapes, bones=bones)


def exchanged_landmarks(rig: Rig) -> Rig:
    """Each has the place of its partner: as symmetric as before."""
    by_name = {mark.name: mark for mark in rig.landmarks}
    places = [by_name[other_side(mark.name)] for mark in rig.landmarks]
    marks = [replace(m, face=p.face, barycentric=p.barycentric) for m, p in zip(rig.landmarks, places, strict=True)]
    return replace(rig, landmarks=tuple(marks))


def turned_about(rig: Rig) -> Rig:
    """Facing backwards: the whole rig turned about its height by half a turn."""
    half = np.array([-1.0, 1.0, -1.0])
    bones = tuple(replace(bone, origin=half * bone.origin) for bone in rig.bones)
    return replace(rig, template=half * rig.template, blendshapes=half * rig.blendshapes, bones=bones)


def pinched(rig: Rig) -> Rig:
    """A second tip that touches the surface in one border vertex only."""
    return with_extra_faces(rig, [[0, 204, 205]], [[0.0, -0.1, 0.2], [0.1, -0.1, 0.2]])


BREAKINGS: list[tuple[str, Breaking]] = [
    ("the parts fit together", lambda rig: replace(rig, uv=rig.uv[:-1])),
    ("all numbers are finite", lambda rig: replace(rig, template=changed(rig.template, 3, np.nan))),
    ("all numbers are finite", lambda rig: replace(rig, blendshapes=changed(rig.blendshapes, (1, 2), np.inf))),
    ("indices are in range", lambda rig: replace(rig, faces=changed(rig.faces, (0, 0), 204))),
    ("indices are in range", lambda rig: replace(rig, faces=changed(rig.faces, 0, [1, 1, 2]))),
    ("indices are in range", lambda rig: with_landmark(rig, face=384)),
    ("indices are in range", lambda rig: replace(rig, regions={"breast_L": np.array([204])})),
    ("every vertex belongs to a triangle", lambda rig: with_extra_faces(rig, [], [[0.0, 0.0, 0.0]])),
    ("the size is that of a body or a part of one", lambda rig: scaled(rig, 100.0)),
    ("the size is that of a body or a part of one", lambda rig: scaled(rig, 0.01)),
    ("left is the patient's left, on +X", exchanged_landmarks),
    ("left is the patient's left, on +X", turned_about),
    (
        "left is the patient's left, on +X",
        lambda rig: replace(rig, shapes=(*rig.shapes[1::-1], *rig.shapes[2:]), blendshapes=rig.blendshapes),
    ),
    ("the surface is a manifold", lambda rig: with_extra_faces(rig, [[13, 26, 40]])),
    ("the surface is a manifold", pinched),
    ("triangles run in one direction", lambda rig: replace(rig, faces=changed(rig.faces, 5, rig.faces[5, ::-1]))),
    (
        "the surface is one piece",
        lambda rig: with_extra_faces(rig, [[204, 205, 206]], [[0.5, 0.0, 0.0], [0.6, 0.0, 0.0], [0.5, 0.1, 0.0]]),
    ),
    ("normals point outwards", lambda rig: replace(rig, faces=rig.faces[:, ::-1])),
    ("borders are smooth", jagged),
    (
        "no slivers in the template",
        lambda rig: replace(rig, template=changed(rig.template, 40, rig.template[41] + [0.0, 0.0005, 0.0])),
    ),
    ("no shape turns a triangle over or makes a sliver", lambda rig: with_shape(rig, 2, min=-12.0)),
    ("texture coordinates are there", lambda rig: replace(rig, uv=np.zeros_like(rig.uv))),
    ("skin weights sum to 1", lambda rig: replace(rig, skin_weights=rig.skin_weights * 1.01)),
    ("skin weights sum to 1", lambda rig: replace(rig, skin_weights=changed(rig.skin_weights, 5, [1.5, -0.5, 0, 0]))),
    ("at most four bones hold a vertex", five_bones_on_one_vertex),
    ("skin weights are smooth", torn_weights),
    ("bones form one tree, parents first", swapped_parent),
    ("bones form one tree, parents first", lambda rig: with_bone(rig, 2, parent=None)),
    ("rest frames are rotations", lambda rig: with_bone(rig, 0, rotation=2.0 * np.eye(3))),
    ("rest frames are rotations", lambda rig: with_bone(rig, 0, rotation=np.diag([-1.0, 1.0, 1.0]))),
    ("joints link all bones to a tree", lambda rig: replace(rig, joints=rig.joints[:-1])),
    ("joints link all bones to a tree", lambda rig: replace(rig, joints=(*rig.joints, rig.joints[0]))),
    ("names are unique, lower case, without dots", lambda rig: with_bone(rig, 0, name="hip.bone", mirror="hip.bone")),
    ("names are unique, lower case, without dots", lambda rig: with_shape(rig, 2, name="flat", mirror="flat")),
    ("ranges and sizes make sense", lambda rig: with_shape(rig, 2, min=0.2)),
    ("ranges and sizes make sense", lambda rig: with_bone(rig, 0, scale_max=np.array([0.9, 1.0, 1.0]))),
    ("every shape does something of its own", lambda rig: replace(rig, blendshapes=changed(rig.blendshapes, 2, 0.0))),
    (
        "every shape does something of its own",
        lambda rig: replace(rig, blendshapes=changed(rig.blendshapes, 3, -2.0 * rig.blendshapes[2])),
    ),
    (
        "landmarks lie on the surface and are explained",
        lambda rig: with_landmark(rig, barycentric=np.array([0.6, 0.6, -0.2])),
    ),
    ("landmarks lie on the surface and are explained", lambda rig: with_landmark(rig, definition="")),
    ("drawings lie on the surface", lambda rig: with_line(rig, SurfacePoints(np.array([1, 2]), np.ones((2, 3))))),
    ("drawings lie on the surface", lambda rig: with_line(rig, SurfacePoints(np.array([1]), np.ones((1, 3)) / 3))),
    ("lines have a colour", lambda rig: with_first_line(rig, color="red")),
    (
        "lines run without jumps",
        lambda rig: with_line(rig, SurfacePoints(np.array([2, 3, 4, 5, 250]), np.ones((5, 3)) / 3)),
    ),
    ("open and closed lines say so", lambda rig: with_first_line(rig, points=there_and_back(rig))),
    ("corners are points of their line", lambda rig: with_first_line(rig, corners=(3, 2))),
    ("corners are points of their line", lambda rig: with_first_line(rig, corners=(999,))),
    ("lines of both sides mirror each other", lambda rig: with_sides(rig, rig.drawings[0].shapes[1].points)),
    ("regions name vertices once", lambda rig: replace(rig, regions={"breast_L": np.array([3, 3])})),
    (
        "the mirror map of vertices leads back",
        lambda rig: replace(rig, mirror_vertices=changed(rig.mirror_vertices, 1, 2)),
    ),
    ("the mirror map of bones leads back", lambda rig: with_bone(rig, 2, mirror="shoulder_L")),
    ("the mirror map of shapes leads back", lambda rig: with_shape(rig, 0, mirror="wide")),
    ("the mirror map of landmarks leads back", lambda rig: with_landmark(rig, mirror="nipple_L")),
    ("the template is symmetric", lopsided),
    (
        "the triangles are symmetric",
        lambda rig: replace(rig, faces=changed(rig.faces, [0, 1], [[0, 1, 12], [1, 13, 12]])),
    ),
    ("the skin weights are symmetric", uneven_weights),
    (
        "the shapes are symmetric",
        lambda rig: replace(rig, blendshapes=changed(rig.blendshapes, 0, 1.1 * rig.blendshapes[0])),
    ),
    ("the shapes are symmetric", lambda rig: with_shape(rig, 0, max=0.9)),
    ("bones and joints are symmetric", lambda rig: with_bone(rig, 2, origin=rig.bones[2].origin + 1e-4)),
    (
        "bones and joints are symmetric",
        lambda rig: replace(rig, joints=(*rig.joints[:2], replace(rig.joints[2], anchor=np.zeros(3)))),
    ),
    ("the landmarks are symmetric", lambda rig: with_landmark(rig, face=0)),
]


@pytest.mark.parametrize(("rule", "breaking"), BREAKINGS, ids=[f"{k}: {rule}" for k, (rule, _) in enumerate(BREAKINGS)])
def test_a_broken_rig_is_caught_by_the_rule_it_breaks(toy_rig: Rig, rule: str, breaking: Breaking) -> None:
    broken = broken_rules(breaking(toy_rig))
    assert rule in broken, f"only these spoke: {list(broken)}"
    assert broken[rule].detail


def test_a_sound_rig_breaks_no_rule(toy_rig: Rig) -> None:
    errors = {name: finding.detail for name, finding in broken_rules(toy_rig).items() if finding.severity == "error"}
    assert errors == {}


def test_a_body_part_without_sides_is_a_sound_rig_too(toy_rig: Rig) -> None:
    """No symmetry is claimed, so none is asked for."""
    count = len(toy_rig.template)
    bent = toy_rig.template + 0.03 * np.sin(8.0 * toy_rig.template[:, 1:2]) * [1.0, 0.0, 0.3]

    def alone(landmark: Landmark, name: str) -> Landmark:
        return replace(landmark, name=name, mirror=name)

    rig = replace(
        toy_rig,
        name="forearm",
        template=bent,
        mirror_vertices=np.arange(count),
        bones=tuple(replace(b, name=n, mirror=n) for b, n in zip(toy_rig.bones, "abcd", strict=True)),
        shapes=tuple(replace(s, name=n, mirror=n) for s, n in zip(toy_rig.shapes, "abcd", strict=True)),
        landmarks=tuple(alone(m, n) for m, n in zip(toy_rig.landmarks, "abc", strict=True)),
    )
    assert broken_rules(rig) == {}


def test_the_description_names_everything(toy_rig: Rig) -> None:
    text = describe_rig(toy_rig)
    for name in (*toy_rig.bone_names, *toy_rig.shape_names, *toy_rig.landmark_names, *toy_rig.drawing_names, "sternum"):
        assert name in text
    assert "204 vertices" in text


def test_a_rig_without_shapes_joints_and_landmarks_can_be_described_and_checked(toy_rig: Rig) -> None:
    bare = replace(
        toy_rig,
        bones=toy_rig.bones[:1],
        skin_weights=np.ones((len(toy_rig.template), 1)),
        joints=(),
        shapes=(),
        blendshapes=np.zeros((0, len(toy_rig.template), 3)),
        landmarks=(),
        drawings=(),
        regions={},
    )
    assert broken_rules(bare) == {}
    assert "0 shapes" in describe_rig(bare)
