import numpy as np
import pytest
import trimesh

from breastrig.geometry.boundary import boundary_edges
from breastrig.geometry.normals import face_normals
from breastrig.geometry.rays import HAVE_EMBREE
from breastrig_studies.virtual.depth_camera import DepthCamera, DepthImage, View, look_at, take
from breastrig_studies.virtual.depth_fusion import fuse, without_small_pieces

pytestmark = pytest.mark.skipif(not HAVE_EMBREE, reason="embreex has no wheel for this platform")

RADIUS = 0.12
PERFECT = DepthCamera(
    width=120, height=90, noise=0.0, step=1e-9, wave=0.0, shift=0.0, turn=0.0, speckle=0.0, field_of_view=0.7
)
UP = np.array([0.0, 1.0, 0.0])


@pytest.fixture(scope="module")
def ball() -> tuple[np.ndarray, np.ndarray]:
    solid = trimesh.creation.icosphere(subdivisions=4, radius=RADIUS)
    return np.array(solid.vertices), np.array(solid.faces)


def around(count: int) -> list[View]:
    angles = np.linspace(-1.2, 1.2, count)
    return [look_at(0.5 * np.array([np.sin(a), 0.2, np.cos(a)]), np.zeros(3), UP) for a in angles]


def shots(ball: tuple[np.ndarray, np.ndarray], camera: DepthCamera, seed: int = 4) -> list[DepthImage]:
    return take(*ball, around(5), camera, np.random.default_rng(seed))


def test_a_perfect_camera_sees_points_of_the_surface(ball: tuple[np.ndarray, np.ndarray]) -> None:
    for image in shots(ball, PERFECT):
        points = image.points()
        assert len(points) > 2000
        assert np.abs(np.linalg.norm(points, axis=1) - RADIUS).max() < 5e-4  # the ball is faceted
        assert (points @ image.view.position > 0).all(), "only the side that looks to the camera is seen"


def test_noise_grows_with_the_square_of_the_distance(ball: tuple[np.ndarray, np.ndarray]) -> None:
    camera = DepthCamera(width=120, height=90, step=1e-9, wave=0.0, shift=0.0, turn=0.0, field_of_view=0.5)
    spread = []
    for away in (0.5, 1.0):
        view = look_at(np.array([0.0, 0.0, away]), np.zeros(3), UP)
        points = take(*ball, [view], camera, np.random.default_rng(0))[0].points()
        middle = np.hypot(points[:, 0], points[:, 1]) < 0.03
        spread.append((np.linalg.norm(points[middle], axis=1) - RADIUS).std())
    assert spread[1] / spread[0] == pytest.approx(((1.0 - RADIUS) / (0.5 - RADIUS)) ** 2, rel=0.25)


def test_drift_is_slow_and_different_in_each_view(ball: tuple[np.ndarray, np.ndarray]) -> None:
    camera = DepthCamera(width=120, height=90, noise=0.0, step=1e-9, speckle=0.0, field_of_view=0.7)
    errors = [np.linalg.norm(image.points(), axis=1) - RADIUS for image in shots(ball, camera)]
    means = np.array([error.mean() for error in errors])
    assert np.abs(means).max() < 0.005
    assert means.std() > 1e-4


def test_blind_spots_and_grazing_skin_do_not_answer(ball: tuple[np.ndarray, np.ndarray]) -> None:
    spot = np.array([[0.0, 0.0, RADIUS, 0.03]])
    view = look_at(np.array([0.0, 0.0, 0.5]), np.zeros(3), UP)
    points = take(*ball, [view], PERFECT, np.random.default_rng(0), spot)[0].points()
    assert np.linalg.norm(points - spot[0, :3], axis=1).min() > 0.02
    assert points[:, 2].min() > 0.02


def test_the_same_seed_gives_the_same_images(ball: tuple[np.ndarray, np.ndarray]) -> None:
    first, second = (shots(ball, DepthCamera(width=60, height=45), seed=7) for _ in range(2))
    np.testing.assert_array_equal(first[2].depth, second[2].depth)


def test_fused_views_are_one_outward_open_surface_near_the_truth(ball: tuple[np.ndarray, np.ndarray]) -> None:
    vertices, faces = fuse(shots(ball, PERFECT), np.full(3, -0.15), np.full(3, 0.15), voxel=0.006)
    assert np.abs(np.linalg.norm(vertices, axis=1) - RADIUS).mean() < 5e-4
    outwards = np.einsum("fi,fi->f", face_normals(vertices, faces), vertices[faces].mean(axis=1))
    assert (outwards > 0).mean() > 0.995
    assert len(boundary_edges(faces)) > 50
    assert vertices[:, 2].min() > -0.09, "the back was not seen"


def test_the_box_cuts_the_surface_off(ball: tuple[np.ndarray, np.ndarray]) -> None:
    vertices, _ = fuse(shots(ball, PERFECT), np.array([-0.15, 0.0, -0.15]), np.full(3, 0.15), voxel=0.006)
    assert vertices[:, 1].min() >= 0.0


def test_nothing_seen_is_an_empty_surface() -> None:
    view = look_at(np.array([0.0, 0.0, 0.5]), np.zeros(3), UP)
    blank = DepthImage(PERFECT, view, np.full((90, 120), np.nan))
    vertices, faces = fuse([blank], np.full(3, -0.1), np.full(3, 0.1), voxel=0.02)
    assert vertices.shape == (0, 3)
    assert faces.shape == (0, 3)


def test_small_pieces_are_left_out() -> None:
    vertices = np.random.default_rng(0).normal(size=(9, 3))
    faces = np.array([[0, 1, 2], [1, 2, 3], [4, 5, 6]])
    kept_vertices, kept, used = without_small_pieces(vertices, faces, smallest=2)
    assert list(used) == [0, 1, 2, 3]
    np.testing.assert_array_equal(kept_vertices, vertices[:4])
    np.testing.assert_array_equal(kept, faces[:2])
