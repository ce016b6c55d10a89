"""Splitting leaves the surface where it is."""

import numpy as np
import pytest
from helpers.exact_geodesics import with_vertex
from helpers.surfaces import sphere

from breastrig.geometry.boundary import boundary_edges
from breastrig.geometry.closest_point import ClosestPointSearch
from breastrig.geometry.half_edges import split_flat
from breastrig.geometry.normals import face_areas, face_crosses


@pytest.mark.parametrize(("share", "more"), [((0.2, 0.5, 0.3), 2), ((0.0, 0.4, 0.6), 2), ((0.0, 1.0, 0.0), 0)])
def test_a_point_becomes_a_vertex(share: tuple[float, ...], more: int) -> None:
    vertices, faces = sphere(0.1, 2)
    place = np.array(share) @ vertices[faces[17]]
    grown, split, owners, vertex = with_vertex(vertices, faces, 17, np.array(share))
    np.testing.assert_allclose(grown[vertex], place, atol=1e-15)
    assert len(split) == len(faces) + more
    assert len(boundary_edges(split)) == 0  # still closed
    assert face_areas(grown, split).sum() == pytest.approx(face_areas(vertices, faces).sum(), rel=1e-12)
    assert (np.einsum("fi,fi->f", face_crosses(grown, split), face_crosses(vertices, faces)[owners]) > 0.0).all()


def test_every_triangle_into_four() -> None:
    vertices, faces = sphere(0.1, 2)
    grown, split, owners = split_flat(vertices, faces)
    assert len(split) == 4 * len(faces)
    assert len(boundary_edges(split)) == 0
    np.testing.assert_allclose(face_areas(grown, split), face_areas(vertices, faces)[owners] / 4.0, rtol=1e-9)
    assert ClosestPointSearch(vertices, faces).query(grown).distances.max() < 1e-12
