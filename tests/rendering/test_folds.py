"""The shading of scans without colours, on shapes whose curvature is known."""

import numpy as np
import pytest
from helpers.surfaces import sphere

from breastrig.core.srgb import to_light
from breastrig.rendering.folds import FLAT, FOLD, bends, shades


def sheet(size: float, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """A square in the plane z = 0, facing +Z."""
    side = np.linspace(-size / 2.0, size / 2.0, steps + 1)
    x, y = (each.ravel() for each in np.meshgrid(side, side, indexing="ij"))
    number = np.arange(len(x)).reshape(steps + 1, steps + 1)
    p, q, r, s = (each.ravel() for each in (number[:-1, :-1], number[1:, :-1], number[:-1, 1:], number[1:, 1:]))
    return np.column_stack([x, y, 0.0 * x]), np.concatenate([np.column_stack([p, q, r]), np.column_stack([q, s, r])])


def test_flat_is_flat_and_a_ball_is_brighter_the_smaller_it_is_and_as_much_darker_from_within() -> None:
    assert bends(*sheet(0.2, 40)) == pytest.approx(0.0, abs=1e-12)
    nipple, breast = (float(np.median(bends(*sphere(radius, 5)))) for radius in (0.01, 0.06))
    assert nipple > 0.85
    assert 0.17 < breast < 0.37  # only a hint
    vertices, faces = sphere(0.01, 5)
    assert float(np.median(bends(vertices, faces[:, ::-1]))) == pytest.approx(-nipple, abs=1e-9)


def test_a_fold_is_darkest_along_its_bottom_and_the_same_on_a_mesh_twice_as_fine() -> None:
    bottoms = []
    for steps in (50, 100):
        vertices, faces = sheet(0.1, steps)
        vertices[:, 2] = np.minimum(0.02, np.hypot(vertices[:, 0], 0.003))  # a valley along y, 3 mm round at its bottom
        found = bends(vertices, faces)
        inside = np.abs(vertices[:, 1]) < 0.03
        bottom, beside = (
            float(np.median(found[inside & (np.abs(np.abs(vertices[:, 0]) - near) < 0.001)])) for near in (0.0, 0.014)
        )
        assert bottom < -0.53
        assert abs(beside) < 0.2
        bottoms.append(bottom)
    assert abs(bottoms[0] - bottoms[1]) < 0.16


def test_noise_as_of_a_depth_camera_on_a_plane_is_hardly_seen() -> None:
    vertices, faces = sheet(0.2, 100)  # edges of 2 mm
    vertices[:, 2] = 0.0004 * (np.random.default_rng(7).random(len(vertices)) - 0.5)  # a tenth of a mm, after fusion
    assert np.sqrt(np.mean(bends(vertices, faces) ** 2)) < 0.126


def test_shades_are_greys_that_leave_room_for_what_is_brighter_than_flat() -> None:
    assert to_light(shades(*sheet(0.2, 40)) / 255.0) == pytest.approx(FLAT, abs=0.01)
    vertices, faces = sphere(0.01, 5)
    assert to_light(shades(vertices, faces) / 255.0).min() > FLAT
    within = to_light(shades(vertices, faces[:, ::-1]) / 255.0)
    assert np.median(within) == pytest.approx(FLAT * (1.0 - FOLD), abs=0.05)
    assert shades(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)).shape == (0, 3)
