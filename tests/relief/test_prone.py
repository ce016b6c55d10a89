"""What hanging breasts show in the depth of a front."""

from dataclasses import replace

import numpy as np
import pytest

from breastrig.core.arrays import Array, Integers
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.starts.orientation import prone_start
from breastrig.geometry.normals import vertex_normals
from breastrig.geometry.rotations import exp_so3
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.relief.prone import seen_from
from breastrig.rig.stance_priors import mean_weights
from breastrig.scan.clean import compact
from breastrig.scan.orient import LABEL_MAP_FRAME, Frame

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


def frame(up: Array, confidence: float) -> Frame:
    return replace(LABEL_MAP_FRAME, up=up, front=TURN[:, 2], fronts=TURN[:, 2:].T, confidence=confidence)


def test_a_turned_front_is_placed_and_its_nipples_are_seen(front: tuple[Array, Integers, dict[str, Array]]) -> None:
    vertices, faces, places = front
    start = prone_start(read_rig(default_rig_path()), ScanTarget(vertices, faces), frame(-TURN[:, 1], 0.5))
    assert np.trace(start.similarity.rotation.T @ TURN) > 2.8
    seen = seen_from(vertices, faces, start.similarity.rotation)
    for name in ("nipple_L", "nipple_R", "xiphoid"):
        assert np.linalg.norm(seen[name] - places[name]) < 0.012, name


def test_a_head_that_is_known_to_be_down_stays_down(front: tuple[Array, Integers, dict[str, Array]]) -> None:
    vertices, faces, _ = front
    start = prone_start(read_rig(default_rig_path()), ScanTarget(vertices, faces), frame(-TURN[:, 1], 1.0))
    assert start.similarity.rotation[:, 1] @ TURN[:, 1] < 0.0


def test_a_plate_has_no_breasts() -> None:
    places = np.array([[x, y, 0.0] for x in (0.0, 0.002) for y in (0.0, 0.002)])
    assert seen_from(places, np.array([[0, 2, 1], [1, 2, 3]]), np.eye(3)) is None
