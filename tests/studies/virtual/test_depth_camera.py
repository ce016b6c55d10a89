import numpy as np
import pytest
import trimesh

from breastrig.geometry.boundary import boundary_edges
from breastrig.geometry.normals import face_normals
from breastrig.geometry.rays import HAVE_EMBREE
from breastrig_studies.virtual.depth_camera import DepthCamera, DepthImage, View, look_at, take
from breastrig_studies.virtual.depth_fusion import fuse

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


def test_fused_views_are_one_outward_open_surface_near_the_truth(ball: tuple[np.ndarray, np.ndarray]) -> None:
    vertices, faces = fuse(shots(ball, PERFECT), np.full(3, -0.15), np.full(3, 0.15), voxel=0.006)
    assert np.abs(np.linalg.norm(vertices, axis=1) - RADIUS).mean() < 5e-4
    outwards = np.einsum("fi,fi->f", face_normals(vertices, faces), vertices[faces].mean(axis=1))
    assert (outwards > 0).mean() > 0.995
    assert len(boundary_edges(faces)) > 50
    assert vertices[:, 2].min() > -0.09, "the back was not seen"
