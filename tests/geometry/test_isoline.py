"""Lines of one level on a plane, where they are circles, straight lines, or nothing."""

import numpy as np
from helpers.surfaces import plane

from breastrig.geometry.isoline import longest_loop


def test_the_longest_of_two_rings_is_taken_in_order() -> None:
    vertices, faces = plane(0.2, 40)
    values = np.minimum(
        np.linalg.norm(vertices - [0.04, 0.0, 0.0], axis=1), np.linalg.norm(vertices - [-0.06, 0.0, 0.0], axis=1) + 0.01
    )
    loop = longest_loop(faces, values, 0.03)
    assert loop is not None
    ends = vertices[loop.edges]
    assert (ends[:, :, 0] > 0.0).all()  # the ring of 30 mm, not the one of 20
    inside = values[loop.edges] < 0.03
    assert (inside.sum(axis=1) == 1).all()  # every edge crosses
    middles = ends.mean(axis=1)
    assert np.linalg.norm(middles - np.roll(middles, 1, axis=0), axis=1).max() < 0.006  # one after the other
    for face, edge in zip(loop.faces, loop.edges, strict=True):
        assert set(edge) <= set(faces[face])


def test_a_ring_cut_by_the_border_is_none() -> None:
    vertices, faces = plane(0.2, 40)
    assert longest_loop(faces, np.linalg.norm(vertices - [0.09, 0.0, 0.0], axis=1), 0.03) is None


def test_a_level_that_is_never_reached_is_none() -> None:
    vertices, faces = plane(0.2, 10)
    assert longest_loop(faces, np.linalg.norm(vertices, axis=1), 9.0) is None
