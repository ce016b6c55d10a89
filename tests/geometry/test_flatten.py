"""Surfaces laid flat: what bends without stretching keeps every length, what does not says so, and rings are slit."""

import numpy as np
import pytest

from breastrig.core.errors import BadDrawing
from breastrig.geometry.boundary import boundary_loops
from breastrig.geometry.flatten import flattened, overlapping, unpinched


def sheet(wide: int, high: int) -> tuple[np.ndarray, np.ndarray]:
    """(V, 2) places 5 mm apart and (F, 3) counter-clockwise triangles."""
    x, y = np.meshgrid(np.arange(wide), np.arange(high))
    corner = (np.arange(high - 1)[:, None] * wide + np.arange(wide - 1)).ravel()
    lower, upper = [corner, corner + 1, corner + wide + 1], [corner, corner + wide + 1, corner + wide]
    return 0.005 * np.stack([x.ravel(), y.ravel()], axis=1), np.concatenate([np.stack(lower, 1), np.stack(upper, 1)])


def on_cylinder(flat: np.ndarray, radius: float = 0.08) -> np.ndarray:
    angle = flat[:, 0] / radius
    return np.stack([radius * np.sin(angle), flat[:, 1], radius * np.cos(angle)], axis=1)


def all_distances(places: np.ndarray) -> np.ndarray:
    return np.linalg.norm(places[:, None] - places[None], axis=2)


@pytest.mark.parametrize("is_ring", [False, True])
def test_a_cylinder_unrolls_without_an_error_also_where_it_is_slit(is_ring: bool) -> None:
    flat, faces = sheet(25, 20)
    middle = np.abs(flat[faces].mean(axis=1) - [0.06, 0.0475])
    if is_ring:
        faces = faces[(middle > [0.03, 0.02]).any(axis=1)]
    used, faces = np.unique(faces, return_inverse=True)
    flat, faces = flat[used], faces.reshape(-1, 3)
    found = flattened(on_cylinder(flat), faces)
    assert len(found.slits) == is_ring
    assert len(boundary_loops(found.faces)) == 1
    given = np.argmin(np.linalg.norm(found.vertices[:, None] - on_cylinder(flat)[None], axis=2), axis=1)
    np.testing.assert_allclose(all_distances(found.flat), all_distances(flat[given]), atol=2e-4)
    a, b, c = found.flat[found.faces].transpose(1, 0, 2)
    assert ((b - a)[:, 0] * (c - a)[:, 1] > (b - a)[:, 1] * (c - a)[:, 0]).all(), "seen from outside"
    for both in found.slits:
        assert len(both) == 2
        np.testing.assert_array_equal(*found.vertices[both])


def test_a_dome_is_stretched_by_what_its_curvature_asks_for() -> None:
    flat, faces = sheet(21, 21)
    flat = flat - flat.mean(axis=0)
    dome = np.column_stack([flat, np.sqrt(0.08**2 - (flat**2).sum(axis=1))])
    found = flattened(dome, faces)
    edges = np.linalg.norm(found.flat[found.faces] - np.roll(found.flat[found.faces], 1, axis=1), axis=2)
    strain = edges / np.linalg.norm(dome[found.faces] - np.roll(dome[found.faces], 1, axis=1), axis=2) - 1.0
    assert 0.05 < np.abs(strain).max() < 0.25  # (half width / radius)² / 6 is 0.07 at the sides, 0.13 at the corners


def test_triangles_that_overlap_are_found_and_refused() -> None:
    flat, faces = sheet(61, 4)
    assert not overlapping(flat, faces).any()
    folded = np.where(flat[:, :1] > 0.15, [0.30, 0.0] - flat * [1.0, -1.0], flat)
    assert overlapping(folded, faces).any()
    angle = 0.14 * flat[:, 0] / 0.005
    spiral = np.stack([np.cos(angle), np.sin(angle)], axis=1) * (0.06 + flat[:, 1:])
    with pytest.raises(BadDrawing, match="overlap"):  # flat already, and more than once around
        flattened(np.column_stack([spiral, np.zeros(len(spiral))]), faces[:, ::-1])


def test_triangles_that_touch_in_a_corner_get_those_around_it() -> None:
    _, faces = sheet(3, 3)
    chosen = np.zeros(len(faces), dtype=bool)
    chosen[[0, 3]] = True  # of the lower left and the upper right square, around the middle
    assert unpinched(faces, chosen).sum() > 2
    chosen[:] = True
    np.testing.assert_array_equal(unpinched(faces, chosen), chosen)
