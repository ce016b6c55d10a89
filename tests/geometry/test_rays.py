import numpy as np
import pytest
import trimesh

from breastrig.geometry import rays
from breastrig.geometry.normals import face_normals
from breastrig.geometry.rays import HAVE_EMBREE, NoRays, RayCaster

pytestmark = pytest.mark.skipif(not HAVE_EMBREE, reason="embreex has no wheel for this platform")

TRIANGLE = (np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
DOWN = np.array([[0.0, 0, -1]])


def ball(shift: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    solid = trimesh.creation.icosphere(subdivisions=3, radius=0.2)
    return np.array(solid.vertices) + shift, np.array(solid.faces)


@pytest.mark.parametrize("shift", [0.0, 5.0])
def test_hits_are_right_to_a_micrometre_wherever_the_mesh_lies(shift: float) -> None:
    vertices, faces = ball(shift)
    directions = np.random.default_rng(1).normal(size=(500, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    origins = np.full((500, 3), shift)
    hit, distance = RayCaster(vertices, faces).first_hits(origins, directions, 1.0)
    assert (hit >= 0).all(), "the ball is closed: no ray may leak"
    normals = face_normals(vertices, faces)[hit]
    exact = np.einsum("mi,mi->m", normals, vertices[faces[hit, 0]] - origins)
    exact /= np.einsum("mi,mi->m", normals, directions)
    np.testing.assert_allclose(distance, exact, atol=1e-6)


def test_the_weights_of_a_hit_give_its_place() -> None:
    vertices, faces = ball(2.0)
    directions = np.random.default_rng(2).normal(size=(500, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    found = RayCaster(vertices, faces).hits(np.full((500, 3), 2.0), directions, 1.0)
    weights = np.stack([1.0 - found.second - found.third, found.second, found.third], axis=1)
    assert weights.min() > -1e-6
    places = np.einsum("mc,mcd->md", weights, vertices[faces[found.faces]])
    np.testing.assert_allclose(places, 2.0 + found.distances[:, None] * directions, atol=1e-6)


def test_rays_through_shared_vertices_do_not_leak() -> None:
    vertices, faces = ball()
    directions = vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    hit, _ = RayCaster(vertices, faces).first_hits(np.zeros_like(vertices), directions, 1.0)
    assert (hit >= 0).all()


def test_a_miss_is_minus_one_and_infinite() -> None:
    hit, distance = RayCaster(*TRIANGLE).first_hits(np.array([[3.0, 3, 1]]), DOWN, 9.0)
    assert hit.dtype == np.int64
    assert hit[0] == -1
    assert distance[0] == np.inf
    missed = RayCaster(*TRIANGLE).hits(np.array([[3.0, 3, 1]]), DOWN, 9.0)
    assert missed.second[0] == missed.third[0] == 0.0


def test_the_limit_can_differ_by_ray_and_stays_untouched() -> None:
    limit = np.array([0.5, 1.5])
    origins = np.tile([[0.2, 0.2, 1.0]], (2, 1))
    hit, distance = RayCaster(*TRIANGLE).first_hits(origins, np.tile(DOWN, (2, 1)), limit)
    assert list(hit) == [-1, 0]
    assert distance[1] == pytest.approx(1.0)
    assert list(limit) == [0.5, 1.5]


def test_both_sides_are_hit() -> None:
    hit, _ = RayCaster(*TRIANGLE).first_hits(np.array([[0.2, 0.2, -1.0]]), -DOWN, 9.0)
    assert hit[0] == 0


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_ray_that_is_not_finite_misses(value: float) -> None:
    origins = np.array([[0.2, 0.2, 1.0], [0.2, value, 1.0]])
    hit, distance = RayCaster(*TRIANGLE).first_hits(origins, np.tile(DOWN, (2, 1)), 9.0)
    assert list(hit) == [0, -1]
    assert distance[1] == np.inf


def test_no_triangles_and_no_rays_are_no_error() -> None:
    empty = RayCaster(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))
    assert list(empty.first_hits(np.zeros((1, 3)), DOWN, 1.0)[0]) == [-1]
    assert RayCaster(*TRIANGLE).first_hits(np.zeros((0, 3)), np.zeros((0, 3)), 1.0)[0].shape == (0,)


def test_what_embree_would_read_beyond_its_end_is_refused() -> None:
    with pytest.raises(ValueError, match="names a vertex"):
        RayCaster(TRIANGLE[0], np.array([[0, 1, 3]]))
    with pytest.raises(ValueError, match="finite"):
        RayCaster(np.full((3, 3), np.nan), TRIANGLE[1])
    with pytest.raises(ValueError, match="shape"):
        RayCaster(*TRIANGLE).first_hits(np.zeros((2, 3)), DOWN, 1.0)


def test_without_embreex_the_way_out_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rays, "HAVE_EMBREE", False)
    with pytest.raises(NoRays, match="install embreex"):
        RayCaster(*TRIANGLE)
