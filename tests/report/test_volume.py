"""Domes whose volume is known: on a plane, on a cylinder, and on the model."""

import numpy as np
import pytest

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.normals import face_areas
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.report.stance import Stance
from breastrig.report.volume import METHOD, Axis, breast_volume, volume_above
from breastrig.rig.parameters import rest_parameters
from breastrig.volume.tetrahedra import volume_mesh

UP = np.array([0.0, 1.0, 0.0])
FAR_AXIS = Axis(np.array([0.0, 0.0, -1e4]), UP)  # around it a plane is as good as flat


def grid(rings: int, spokes: int) -> Integers:
    """(F, 3) triangles of `rings` circles of `spokes` points around a first point, outwards is +z."""
    faces = [[0, 1 + k, 1 + (k + 1) % spokes] for k in range(spokes)]
    for ring in range(rings - 1):
        a = 1 + ring * spokes
        for k in range(spokes):
            here, there = a + k, a + (k + 1) % spokes
            faces += [[here, here + spokes, there + spokes], [here, there + spokes, there]]
    return np.array(faces, dtype=np.int64)


def revolved(profile: Array, spokes: int = 96) -> tuple[Array, Integers]:
    """A surface from a (N, 2) m profile of radius and height whose first point lies on the z axis."""
    turn = 2.0 * np.pi * np.arange(spokes) / spokes
    rings = [np.stack([r * np.cos(turn), r * np.sin(turn), np.full(spokes, z)], axis=1) for r, z in profile[1:]]
    return np.concatenate([[[0.0, 0.0, profile[0, 1]]], *rings]), grid(len(profile) - 1, spokes)


def dome(radius: float, lowest: float = 0.0) -> tuple[Array, Integers, Array]:
    """A hemisphere on a plane, and the distance to its rim; `lowest` turns its rim inwards (m below the equator)."""
    angles = np.linspace(0.0, np.pi / 2 + np.arcsin(lowest / radius), 60)
    ball = np.stack([radius * np.sin(angles), lowest + radius * np.cos(angles)], axis=1)
    foot = ball[-1, 0]
    plane = np.stack([np.linspace(foot, 2.5 * radius, 40)[1:], np.zeros(39)], axis=1)
    vertices, faces = revolved(np.concatenate([ball, plane]))
    away = np.hypot(np.hypot(vertices[:, 0], vertices[:, 1]) - foot, vertices[:, 2])
    inside = np.arange(len(vertices)) < 1 + 58 * 96
    return vertices, faces, np.where(inside, away, -away)


def test_a_hemisphere_on_a_plane_has_two_thirds_of_pi_r_cubed() -> None:
    vertices, faces, inside = dome(0.06)
    volume, area = volume_above(vertices, faces, inside, FAR_AXIS)
    assert volume == pytest.approx(2.0 / 3.0 * np.pi * 0.06**3, rel=3e-3)  # the facets lie below the sphere
    assert area == pytest.approx(2.0 * np.pi * 0.06**2, rel=3e-3)


def test_a_dome_that_hangs_over_its_rim_counts_its_own_tissue_only() -> None:
    """A ball sunk by less than its radius: the whole of its part above the plane, undercut or not."""
    radius, below = 0.06, 0.03
    vertices, faces, inside = dome(radius, below)
    height = radius + below
    volume, _ = volume_above(vertices, faces, inside, FAR_AXIS)
    assert volume == pytest.approx(np.pi * height**2 * (3.0 * radius - height) / 3.0, rel=5e-3)


def test_a_flat_plane_has_none() -> None:
    vertices, faces, inside = dome(0.06)
    flat = vertices * [1.0, 1.0, 0.0]
    volume, _ = volume_above(flat, faces, inside, FAR_AXIS)
    assert abs(volume) < 1e-9


def test_around_a_body_a_plane_is_still_known_to_two_per_cent() -> None:
    vertices, faces, inside = dome(0.06)
    volume, _ = volume_above(vertices, faces, inside, Axis(np.array([0.0, 0.0, -0.12]), UP))
    assert volume == pytest.approx(2.0 / 3.0 * np.pi * 0.06**3, rel=2e-2)


def on_cylinder(curvature: float, width: float, depth: float) -> tuple[Array, Integers, Array]:
    """An ellipsoidal cap (half axes `width`, `width`, `depth` in the unrolled plane) on a cylinder around Y."""
    radii = width * np.concatenate([np.sin(np.linspace(0.0, np.pi / 2, 60)), np.linspace(1.0, 1.6, 40)[1:]])
    flat, faces = revolved(np.stack([radii, np.zeros_like(radii)], axis=1))
    along = np.hypot(flat[:, 0], flat[:, 1])
    rise = depth * np.sqrt(np.maximum(1.0 - (along / width) ** 2, 0.0))
    angle, reach = flat[:, 0] / curvature, curvature + rise
    vertices = np.stack([reach * np.sin(angle), flat[:, 1], reach * np.cos(angle)], axis=1)
    return vertices, faces, np.where(np.arange(len(along)) < 1 + 58 * 96, width - along, np.minimum(width - along, 0.0))


@pytest.mark.parametrize("depth", [0.01, 0.04])
def test_an_ellipsoidal_cap_on_a_cylinder(depth: float) -> None:
    curvature, width = 0.14, 0.06
    vertices, faces, inside = on_cylinder(curvature, width, depth)
    true = 2.0 / 3.0 * np.pi * width**2 * depth + np.pi * width**2 * depth**2 / (4.0 * curvature)
    volume, area = volume_above(vertices, faces, inside, Axis(np.zeros(3), UP))
    assert volume == pytest.approx(true, rel=1e-2)
    assert area == pytest.approx(face_areas(vertices, faces[(inside[faces] >= 0.0).all(axis=1)]).sum(), rel=3e-2)


def test_the_outline_farther_in_leaves_less() -> None:
    vertices, faces, inside = dome(0.06)
    volumes = [volume_above(vertices, faces, inside, FAR_AXIS, level)[0] for level in (0.01, 0.005, 0.0)]
    assert volumes[0] < volumes[1] < volumes[2]


def test_nothing_inside_has_no_volume() -> None:
    vertices, faces, inside = dome(0.06)
    assert volume_above(vertices, faces, inside, FAR_AXIS, level=1.0) == (0.0, 0.0)


def test_the_mesh_of_the_same_body_goes_on_to_the_muscle_by_the_layer_that_is_said() -> None:
    """Two walls: what lies between them is one layer of fat, which the table's method and the command name."""
    rig = read_rig(default_rig_path())
    found = Stance(rig, rig.template, rig.template, rig.faces, "standing")
    mesh = volume_mesh(rig, rest_parameters(rig), rig.template)
    for side in "LR":
        ours = breast_volume(found, side)
        layer = (mesh.volumes[mesh.inside(f"breast_{side}")].sum() - ours.value) / ours.area
        assert layer == pytest.approx(0.012, abs=0.001)
    assert "`breastrig volume` go on to the pectoral muscle, some 12 mm deeper" in METHOD
