"""Crossings that were made on purpose."""

import numpy as np
from helpers.surfaces import plane, sphere

from breastrig.geometry.self_intersections import crossing_faces, untangled


def test_a_sphere_crosses_itself_nowhere() -> None:
    vertices, faces = sphere(0.1, 3)
    assert len(crossing_faces(vertices, faces)) == 0
    assert (untangled(vertices, faces) == vertices).all()


def test_two_sheets_cross_where_they_meet() -> None:
    vertices, faces = plane(0.2, 20)
    upright = vertices[:, [0, 2, 1]] + [0.0, 0.0031, 0.0017]
    found = crossing_faces(np.concatenate([vertices, upright]), np.concatenate([faces, faces + len(vertices)]))
    assert len(found) >= 2 * 20
    both = np.concatenate([vertices, upright])
    middle = both[np.concatenate([faces, faces + len(vertices)])[found]].mean(axis=1)
    assert np.hypot(middle[:, 1], middle[:, 2]).max() < 0.02


def test_a_fold_is_smoothed_out_and_the_rest_stays() -> None:
    vertices, faces = sphere(0.1, 3)
    folded = vertices.copy()
    patch = np.linalg.norm(vertices - [0.0, 0.0, 0.1], axis=1) < 0.02
    folded[patch] += [0.03, 0.0, -0.008]  # slides over its neighbours and dips below them
    assert len(crossing_faces(folded, faces)) > 10
    mended = untangled(folded, faces)
    assert len(crossing_faces(mended, faces)) == 0
    far = vertices[:, 2] < 0.05
    assert (mended[far] == folded[far]).all()
