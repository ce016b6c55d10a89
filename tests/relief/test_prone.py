"""What hanging breasts show in the depth of a front."""

import numpy as np
import pytest

from breastrig.core.arrays import Array, Integers
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.rotations import exp_so3
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.relief.prone import prone_views, seen_from
from breastrig.rig.stance_priors import mean_weights
from breastrig.scan.clean import compact

TURN = exp_so3(np.array([0.9, -0.4, 1.7]))


@pytest.fixture(scope="module")
def front() -> tuple[Array, Integers, dict[str, Array]]:
    rig = read_rig(default_rig_path())
    body = rig.template + np.tensordot(mean_weights(rig, "prone"), rig.blendshapes, axes=1)
    places = dict(zip(rig.landmark_names, rig.landmark_points().positions(body, rig.faces), strict=True))
    low, high = places["xiphoid"][1] - 0.06, places["suprasternal_notch"][1] + 0.01
    seen = (body[:, 1] > low) & (body[:, 1] < high) & (vertex_normals(body, rig.faces)[:, 2] > 0.0)
    seen[np.concatenate([rig.regions["arm_L"], rig.regions["arm_R"]])] = False
    vertices, faces = compact(body, rig.faces[seen[rig.faces].all(axis=1)])
    return vertices @ TURN.T, faces, {name: TURN @ place for name, place in places.items()}


def test_the_axes_and_nipples_are_found_on_a_turned_front(front: tuple[Array, Integers, dict[str, Array]]) -> None:
    vertices, faces, places = front
    views = list(prone_views(vertices, faces, TURN[:, 2]))
    assert len(views) == 2
    assert views[0].axes[:, 1] @ views[1].axes[:, 1] < -0.8  # the head on either side
    view = max(views, key=lambda each: float(each.axes[:, 1] @ TURN[:, 1]))
    assert np.trace(view.axes.T @ TURN) > 2.8
    for name in ("nipple_L", "nipple_R", "xiphoid"):
        assert np.linalg.norm(view.places[name] - places[name]) < 0.012, name


def test_a_plate_has_no_breasts() -> None:
    places = np.array([[x, y, 0.0] for x in (0.0, 0.002) for y in (0.0, 0.002)])
    assert seen_from(places, np.array([[0, 2, 1], [1, 2, 3]]), np.eye(3)) is None
