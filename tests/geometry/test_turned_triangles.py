"""Folds of a surface are found, and nothing else is."""

import numpy as np
from helpers.surfaces import plane, sphere

from breastrig.geometry.normals import turned_triangles


def test_a_sheet_and_a_ball_have_none() -> None:
    for vertices, faces in (plane(), sphere()):
        assert not turned_triangles(vertices, faces).any()


def test_a_strip_that_is_pushed_over_the_next_is_found_and_nothing_else() -> None:
    vertices, faces = plane()  # 1 cm cells
    x = vertices[:, 0]
    folded = vertices.copy()
    folded[np.abs(x - 0.01) < 1e-6, 0] = -0.005  # one row of vertices moved beyond the row before it
    between = (x[faces].min(axis=1) > -0.001) & (x[faces].max(axis=1) < 0.011)
    np.testing.assert_array_equal(turned_triangles(folded, faces), between)
    assert between.sum() == 40
