"""A start without landmarks: any orientation is turned the right way, left and right never exchanged."""

import numpy as np
import pytest
from helpers.random_pose import random_parameters
from helpers.subdivide import subdivided
from helpers.surfaces import sphere

from breastrig.core.stances import AUTO
from breastrig.correspondence.target import ScanTarget
from breastrig.fitting.hypotheses import scan_orientation
from breastrig.fitting.prepare_scan import prepared
from breastrig.fitting.recipe import load_recipe
from breastrig.fitting.starts.orientation import start_from_scan, trunks
from breastrig.geometry.rotations import exp_so3
from breastrig.gltf.read_rig import default_rig_path, read_rig
from breastrig.rig.skinning import pose
from breastrig.scan.clean import Surface

pytestmark = pytest.mark.long


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "all_sides"), [(0, False), (1, True)])
def test_a_scan_turned_at_random_is_put_upright(seed: int, all_sides: bool) -> None:
    rig = read_rig(default_rig_path())
    rng = np.random.default_rng(seed)
    vertices = pose(rig, random_parameters(rig, rng, turn=0.05, move=0.0, scale=0.03, shape=0.4))
    behind = -np.inf if all_sides else -0.02  # what the camera saw from the front
    seen = vertices[rig.faces].mean(axis=1)[:, 2] > behind
    fine, triangles = subdivided(vertices, rig.faces[seen])
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    scan = prepared(Surface(fine @ turn.T + rng.normal(size=3), triangles, ()), AUTO)
    frame = scan_orientation(rig, scan, load_recipe("default"))[0].body_frame()
    assert frame["up"] @ turn[:, 1] > np.cos(np.radians(15))
    assert frame["front"] @ turn[:, 2] > np.cos(np.radians(15))
    assert frame["confidence"] > 0.2
    start = start_from_scan(rig, ScanTarget(fine @ turn.T, triangles), np.array([frame["front"]]))
    names = rig.landmark_names
    found = rig.landmark_points().positions(pose(rig, start.parameters), rig.faces)
    true = rig.landmark_points().positions(vertices, rig.faces) @ turn.T
    nearer = [int(np.linalg.norm(true - place, axis=1).argmin()) for place in found]
    sided = [k for k, name in enumerate(names) if name.startswith(("nipple", "acromion"))]
    assert [nearer[k] for k in sided] == sided


@pytest.mark.slow
@pytest.mark.parametrize("part", ["left half"])
def test_a_part_of_a_body_is_put_where_it_belongs(part: str) -> None:
    """Half the body's width or height, as a camera saw it from the front."""
    rig = read_rig(default_rig_path())
    rng = np.random.default_rng(11)
    vertices = pose(rig, random_parameters(rig, rng, turn=0.05, move=0.0, scale=0.03, shape=0.4))
    centres = vertices[rig.faces].mean(axis=1)
    true = rig.landmark_points().positions(vertices, rig.faces)
    nipples = true[rig.landmark_names.index("nipple_L"), 1]
    kept = {
        "left half": centres[:, 0] > 0.0,
        "below the nipples": centres[:, 1] < nipples,
    }[part]
    fine, triangles = subdivided(vertices, rig.faces[kept & (centres[:, 2] > -0.02)])
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    scan = prepared(Surface(fine @ turn.T, triangles, ()), AUTO)
    start = start_from_scan(rig, scan.target, scan.frame.fronts)
    found = rig.landmark_points().positions(pose(rig, start.parameters), rig.faces)
    assert np.linalg.norm(found - true @ turn.T, axis=1).mean() < 0.03


def test_of_a_person_from_head_to_feet_the_trunk_is_looked_at_alone_either_way_up() -> None:
    turn = exp_so3(np.array([0.3, -1.1, 0.7]))
    vertices, faces = sphere()
    vertices = (vertices / np.ptp(vertices, axis=0)) @ np.diag([0.4, 1.65, 0.3]) @ turn.T
    fronts = np.array([[0.0, 0.0, 1.0]])
    whole, *parts = trunks(ScanTarget(vertices, faces), fronts)
    assert (len(whole[0].vertices), whole[2]) == (len(vertices), 1.0)
    ends = sorted(np.percentile(part.vertices @ turn[:, 1] / 1.65 + 0.5, [0, 100]).tolist() for part, *_ in parts)
    np.testing.assert_allclose(ends, [[0.1, 0.53], [0.47, 0.9]], atol=0.04)
    for part, turns, scale in parts:
        assert scale == pytest.approx(1.65 / 1.55, rel=0.02)
        np.testing.assert_allclose(np.linalg.det(turns), 1.0)
        outer_end = np.sign(part.vertices.mean(axis=0) @ turn[:, 1])  # where the head is, of either way up
        assert (turns[:, :, 1] @ turn[:, 1] * outer_end > 0.999).all()
    assert len([*trunks(ScanTarget(0.6 * vertices, faces), fronts)]) == 1
